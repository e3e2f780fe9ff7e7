"""Dynamics of a robot with loops by its independent coordinates.

Loops hold J qdd = -J' qd. With I the independent coordinates and D the others,

    qdd_D = -J_D⁻¹ (J_I qdd_I + J' qd),   qdd = N qdd_I + c,   J N = 0,

and N' takes the constraint forces out of M qdd + C + G + D qd = -L'f + J'p, whatever they are:

    N'M N qdd_I + N'(C + G + D qd + M c) = -(L N)'f.

The terms keep the size of the robot: rows and columns of dependent coordinates are 0, and 1 on the
diagonal of M.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import islice

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Robot, SimulationError
from sim_dart.core.arrays import BoolArray, FloatArray, finite
from sim_dart.core.blob import compile_blob
from sim_dart.core.close_loops import closed_pose
from sim_dart.core.library import Core

from .core import CoreDynamics

_SHARE = 1e-8  # the least pivot, of the largest: what the C core takes as well
_NONE = 1e-12  # a Jacobian of loops as small as this is none
_POSES = 24  # that a choice of coordinates is judged at
_POOR = 1e-3  # the least singular value of J_D that a choice is made for, of the largest of J


class IndependentDynamics(CoreDynamics):
    """Dynamics of a robot whose loops make coordinates follow from the others.

    M, C, G, L and the tasks' J and J' qd are those of the motion equation without constraint
    forces; damping is in C, limits are left of the independent coordinates only. Positions and
    velocities are those of all coordinates, with closed loops.

    Args:
        robot: The robot, with loops.
        dependent: Which coordinates follow from the others, shape (n,); chosen when None.
        may_be_singular: See `CoreDynamics`.

    Raises:
        InputError: The dependent coordinates do not follow from the others.
    """

    def __init__(
        self,
        robot: Robot,
        dependent: ArrayLike | None = None,
        *,
        may_be_singular: bool = False,
    ) -> None:
        chosen = dependent_coordinates(robot) if dependent is None else dependent
        self._dependent = np.asarray(chosen, bool)
        self._flags = self._dependent.astype(float)
        super().__init__(robot, may_be_singular=may_be_singular)
        self.q_min = np.where(self.dependent, -np.inf, self.q_min)
        self.q_max = np.where(self.dependent, np.inf, self.q_max)
        self._N = self._core.array("free_motion", self.n, self.n)
        self._c = self._core.array("free_bias", self.n)
        self._all_damping, self.damping = self.damping, np.zeros(self.n)

    @property
    def dependent(self) -> BoolArray:
        """Which coordinates follow from the others, shape (n,)."""
        return self._dependent

    def closed(self, q: ArrayLike) -> FloatArray:
        """Return the pose in which the loops are closed by the dependent coordinates, shape (n,).

        Raises:
            InputError: They cannot be closed.
        """
        held = (~self._dependent).astype(float)
        return closed_pose(self.robot, self._core, finite("q", q, self.n), held)

    def free_motion(self, q: ArrayLike) -> FloatArray:
        """N(q), shape (n, n), whose columns of dependent coordinates are 0.

        Raises:
            SimulationError: A coordinate does not follow from the independent ones at this pose.
        """
        self._go(q)
        return self._N.copy()

    def free_bias(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """c(q, qd), shape (n,), in [rad/s²] or [m/s²]."""
        self._go(q, qd)
        return self._c.copy()

    def complete(self, q: ArrayLike, qd: ArrayLike, qdd: FloatArray) -> FloatArray:
        """N qdd + c: the accelerations of all coordinates, shape (n,), in [rad/s²] or [m/s²]."""
        self._go(q, qd)
        all_of_them = finite("qdd", qdd, self.n).copy()
        self._core.complete(self._handle, all_of_them.ctypes.data)
        return all_of_them

    def mass_matrix(self, q: ArrayLike) -> FloatArray:
        """N'M N, and 1 for dependent coordinates, shape (n, n)."""
        M = super().mass_matrix(q)
        self._go(q)
        self._core.independent_mass(self._handle, self._flags.ctypes.data, M.ctypes.data)
        return M

    def coriolis(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """N'(C + M c + D qd), shape (n,), in [N·m] or [N]."""
        h = super().coriolis(q, qd) + self._all_damping * finite("qd", qd, self.n)
        M = super().mass_matrix(q)
        self._go(q, qd)
        self._core.independent_bias(self._handle, self.n, M.ctypes.data, h.ctypes.data)
        return self._narrowed(h)

    def gravity(self, q: ArrayLike) -> FloatArray:
        """N'G, shape (n,), in [N·m] or [N]."""
        return self._rows(q, super().gravity(q))

    def load(self, q: ArrayLike, w: ArrayLike) -> FloatArray:
        """N'w of a generalised load, shape (n,), in [N·m] or [N]."""
        return self._rows(q, finite("w", w, self.n))

    def muscle_jacobian(self, q: ArrayLike) -> FloatArray:
        """L N, shape (m, n), in [m/rad] or [m/m]."""
        return self._rows(q, super().muscle_jacobian(q))

    def actuator_jacobian(self, q: ArrayLike) -> FloatArray:
        """L N, and behind it a row for each motor, shape (m + motors, n)."""
        return self._rows(q, super().actuator_jacobian(q))

    def task_jacobian(self, q: ArrayLike) -> FloatArray:
        """J N of the tasks, shape (k, n)."""
        return self._rows(q, super().task_jacobian(q))

    def task_bias(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """J' qd + J c of the tasks, shape (k,), in [m/s²] or [rad/s²]."""
        bias, J = super().task_bias(q, qd), np.ascontiguousarray(super().task_jacobian(q))
        self._go(q, qd)
        self._core.independent_bias(self._handle, len(J), J.ctypes.data, bias.ctypes.data)
        return bias

    def point_jacobian(self, q: ArrayLike) -> FloatArray:
        """J N of the task frames that are points, shape (3 p, n)."""
        return self._rows(q, super().point_jacobian(q))

    def _go(self, q: ArrayLike, qd: ArrayLike | None = None) -> None:
        """Find N and c at a state."""
        core, rates = self._core, np.zeros(self.n) if qd is None else finite("qd", qd, self.n)
        core.move(self._handle, finite("q", q, self.n).tobytes())
        bad = core.free_motion(self._handle, self._flags.ctypes.data, rates.tobytes())
        if bad:
            problem = "does not follow from the independent coordinates at this pose"
            raise SimulationError(f"where loops close, {self.coordinate_names[bad - 1]} {problem}")

    def _rows(self, q: ArrayLike, rows: FloatArray) -> FloatArray:
        """Return rows N: of a Jacobian, or of a generalised force."""
        self._go(q)
        return self._narrowed(np.array(rows))

    def _narrowed(self, rows: FloatArray) -> FloatArray:
        count = rows.size // self.n
        self._core.independent_rows(self._handle, count, rows.ctypes.data)
        return rows


def control_dynamics(
    robot: Robot, dependent: ArrayLike | None = None, *, may_be_singular: bool = False
) -> CoreDynamics:
    """The dynamics that a controller of a robot needs: by independent coordinates with loops.

    Args:
        robot: The robot.
        dependent: Which coordinates follow from the others; chosen when None.
        may_be_singular: See `CoreDynamics`.
    """
    if not robot.loops:
        return CoreDynamics(robot, may_be_singular=may_be_singular)
    return IndependentDynamics(robot, dependent, may_be_singular=may_be_singular)


def dependent_coordinates(
    robot: Robot, among: Collection[str] = (), never: Collection[str] = ()
) -> tuple[bool, ...]:
    """Coordinates that follow from the others, by loops: as well as can be, wherever the robot is.

    Sets that are good in one pose are compared at poses all over the limits.

    Args:
        robot: A valid robot.
        among: Names of some that are to be dependent in any case.
        never: Names of some that are not to be.

    Returns:
        n flags; none is set without loops.

    Raises:
        InputError: There is no such set.
    """
    names = [c.name for c in robot.coordinates]
    if not robot.loops:
        return (False,) * len(names)
    core = CoreDynamics(robot, may_be_singular=True)
    jacobians = [core.loop_jacobian(q) for q in islice(_closed_poses(robot), _POSES)]
    if not jacobians:
        raise InputError(f"robot {robot.name!r}: no pose near its initial one closes its loops")
    rank = max(int(np.linalg.matrix_rank(J, 1e-7 * np.linalg.norm(J))) for J in jacobians)
    if not among and max(np.linalg.norm(J) for J in jacobians) <= _NONE:
        return (False,) * len(names)  # loops of what is rigid anyway
    preference = np.array([2.0 * (name in among) - 1.0 * (name in never) for name in names])
    sets = {tuple(sorted(_picked(J, rank, preference))) for J in jacobians}
    best = max(sorted(sets), key=lambda chosen: _quality(jacobians, chosen))
    asked = {names.index(n) for n in among if n in names}
    barred = {names.index(n) for n in never if n in names}
    if _quality(jacobians[:1], best) <= _SHARE or not asked <= set(best) or barred & set(best):
        which = [f"{n} dependent" for n in among] + [f"{n} independent" for n in never]
        chosen = f" with {', '.join(which)}" if which else ""
        problem = "its loops make others follow" if which else "its loops are in a singular pose"
        raise InputError(f"there are no independent coordinates{chosen}: {problem}")
    return tuple(k in best for k in range(len(names)))


def _closed_poses(robot: Robot) -> list[FloatArray]:
    """Closed poses: that next to the initial one first, then others within the limits."""
    initial = np.array([c.initial for c in robot.coordinates])
    core, rng, poses = Core(compile_blob(robot)), np.random.default_rng(0), []
    low = np.array([max(c.lower, c.initial - 1.5) for c in robot.coordinates])
    high = np.array([min(c.upper, c.initial + 1.5) for c in robot.coordinates])
    for k in range(_POSES):
        at = initial if k == 0 else rng.uniform(np.minimum(low, high), np.maximum(low, high))
        try:
            poses.append(closed_pose(robot, core, at))
        except InputError:
            if k == 0:
                raise
    return poses


def _picked(J: FloatArray, rank: int, preference: FloatArray) -> list[int]:
    """Return columns of J that are as far from depending on each other as a greedy choice finds."""
    left, chosen = J.copy(), list[int]()
    for _ in range(rank):
        sizes = np.linalg.norm(left, axis=0)
        able = sizes > 1e-6 * np.linalg.norm(J)
        if chosen:
            able[chosen] = False
        if not able.any():
            break
        best = int(np.lexsort((sizes, np.where(able, preference, -np.inf)))[-1])
        chosen.append(best)
        unit = left[:, best] / sizes[best]
        left = left - np.outer(unit, unit @ left)
    return chosen


def _quality(jacobians: Sequence[FloatArray], chosen: Sequence[int]) -> float:
    """How far J_D is from singular: at the first pose, if it is poor there, else at the worst."""
    values = []
    for J in jacobians:
        sizes = np.linalg.svd(J[:, list(chosen)], compute_uv=False)
        most = np.linalg.norm(J, 2)
        least = sizes[-1] if len(sizes) == len(chosen) and len(sizes) else 0.0
        values.append(float(least / most) if most > 0.0 else 0.0)
    return values[0] if values[0] <= _POOR else max(_POOR, 1e-12) + min(values)
