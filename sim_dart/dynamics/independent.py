"""Dynamics of a robot with loops in its independent coordinates.

The loop constraints are J qdd = -J' qd. With independent coordinates I and dependent ones D,

    qdd_D = -J_D⁻¹ (J_I qdd_I + J' qd),   qdd = N qdd_I + c,   J N = 0,

and N' eliminates the constraint forces p from M qdd + C + G + D qd = -L'f + J'p:

    N'M N qdd_I + N'(C + G + D qd + M c) = -(L N)'f.

All arrays keep the size of the robot. Rows and columns of dependent coordinates are 0, and their
diagonal elements of M are 1.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import islice

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Robot, SimulationError
from sim_dart.core.arrays import BoolArray, FloatArray, finite
from sim_dart.core.blob import compile_blob
from sim_dart.core.close_loops import closed_pose, remaining_gap
from sim_dart.core.library import Core

from .core import CoreDynamics

_SHARE = 1e-8  # smallest accepted pivot, relative to the largest, as in the C core
_NONE = 1e-12  # loop Jacobians below this value are treated as zero
_POSES = 24  # number of poses at which a choice of coordinates is evaluated
_POOR = 1e-3  # smallest acceptable singular value of J_D, relative to the largest of J


class IndependentDynamics(CoreDynamics):
    """Dynamics of a robot with loops, reduced to independent coordinates.

    M, C, G, L and the J and J' qd of the task belong to the reduced equations of motion without
    constraint forces. C includes damping. Only independent coordinates have joint limits. The
    arguments q and qd contain all coordinates and must satisfy the loop constraints.

    Args:
        robot: The robot, with loops.
        dependent: Flags of the dependent coordinates, shape (n,) (default: selected
            automatically).
        may_be_singular: See `CoreDynamics`.

    Raises:
        InputError: The loops do not determine the dependent coordinates.
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
        self._all_damping, self.damping = self.damping, np.zeros(self.n)

    @property
    def dependent(self) -> BoolArray:
        """Flags of the dependent coordinates, shape (n,)."""
        return self._dependent

    def closed(self, q: ArrayLike) -> FloatArray:
        """Return the pose with closed loops for the independent coordinates of q, shape (n,).

        Raises:
            InputError: The loops cannot be closed.
        """
        is_independent = (~self._dependent).astype(float)
        return closed_pose(self.robot, self._core, finite("q", q, self.n), is_independent)

    def remaining_gap(self, q: ArrayLike) -> float:
        """Return the largest gap of the closed loops, see `sim_dart.core.close_loops`."""
        self.closed(q)
        return remaining_gap(self.robot, self._core)

    def free_motion(self, q: ArrayLike) -> FloatArray:
        """Return N(q), shape (n, n). Columns of dependent coordinates are 0.

        Raises:
            SimulationError: The loops do not determine a dependent coordinate at this pose.
        """
        self._update(q)
        return self._N.copy()

    def complete(self, q: ArrayLike, qd: ArrayLike, qdd: FloatArray) -> FloatArray:
        """Return the accelerations of all coordinates, N qdd + c, in [rad/s²] or [m/s²]."""
        self._update(q, qd)
        all_of_them = finite("qdd", qdd, self.n).copy()
        self._core.complete(self._handle, all_of_them.ctypes.data)
        return all_of_them

    def mass_matrix(self, q: ArrayLike) -> FloatArray:
        """Return N'M N, with 1 on the diagonal for dependent coordinates, shape (n, n)."""
        M = super().mass_matrix(q)
        self._update(q)
        self._core.independent_mass(self._handle, self._flags.ctypes.data, M.ctypes.data)
        return M

    def coriolis(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """Return N'(C + M c + D qd), shape (n,), in [N·m] or [N]."""
        h = super().coriolis(q, qd) + self._all_damping * finite("qd", qd, self.n)
        M = super().mass_matrix(q)
        self._update(q, qd)
        self._core.independent_bias(self._handle, self.n, M.ctypes.data, h.ctypes.data)
        return self._reduce(h)

    def gravity(self, q: ArrayLike) -> FloatArray:
        """Return N'G, shape (n,), in [N·m] or [N]."""
        return self._rows(q, super().gravity(q))

    def load(self, q: ArrayLike, w: ArrayLike) -> FloatArray:
        """Return N'w for a generalised load w, shape (n,), in [N·m] or [N]."""
        return self._rows(q, finite("w", w, self.n))

    def muscle_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return L N, shape (m, n), in [m/rad] or [m/m]."""
        return self._rows(q, super().muscle_jacobian(q))

    def actuator_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return L N followed by a row for each motor, shape (m + motors, n)."""
        return self._rows(q, super().actuator_jacobian(q))

    def task_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return J N of the task, shape (k, n)."""
        return self._rows(q, super().task_jacobian(q))

    def task_bias(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """Return J' qd + J c of the task, shape (k,), in [m/s²] or [rad/s²]."""
        bias, J = super().task_bias(q, qd), np.ascontiguousarray(super().task_jacobian(q))
        self._update(q, qd)
        self._core.independent_bias(self._handle, len(J), J.ctypes.data, bias.ctypes.data)
        return bias

    def point_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return J N of the position task frames, shape (3 p, n)."""
        return self._rows(q, super().point_jacobian(q))

    def _update(self, q: ArrayLike, qd: ArrayLike | None = None) -> None:
        """Compute N and c at a state."""
        core, rates = self._core, np.zeros(self.n) if qd is None else finite("qd", qd, self.n)
        core.move(self._handle, finite("q", q, self.n).tobytes())
        bad = core.free_motion(self._handle, self._flags.ctypes.data, rates.tobytes())
        if bad:
            problem = "is not determined by the independent coordinates of the closed loops"
            raise SimulationError(f"{self.coordinate_names[bad - 1]} {problem} at this pose")

    def _rows(self, q: ArrayLike, rows: FloatArray) -> FloatArray:
        """Return the product of N with rows of a Jacobian or with a generalised force."""
        self._update(q)
        return self._reduce(np.array(rows))

    def _reduce(self, rows: FloatArray) -> FloatArray:
        count = rows.size // self.n
        self._core.independent_rows(self._handle, count, rows.ctypes.data)
        return rows


def control_dynamics(
    robot: Robot, dependent: ArrayLike | None = None, *, may_be_singular: bool = False
) -> CoreDynamics:
    """Return the dynamics of a robot for a controller, in independent coordinates if it has loops.

    Args:
        dependent: Flags of the dependent coordinates (default: selected automatically).
        may_be_singular: See `CoreDynamics`.
    """
    if not robot.loops:
        return CoreDynamics(robot, may_be_singular=may_be_singular)
    return IndependentDynamics(robot, dependent, may_be_singular=may_be_singular)


def dependent_coordinates(
    robot: Robot, required: Collection[str] = (), excluded: Collection[str] = ()
) -> tuple[bool, ...]:
    """Select the coordinates that the loops determine from the others.

    Candidate sets are compared by their conditioning at several poses within the joint limits.

    Args:
        robot: A valid robot.
        required: Names of coordinates that must be dependent.
        excluded: Names of coordinates that must be independent.

    Returns:
        n flags, all false without loops.

    Raises:
        InputError: No such set exists.
    """
    names = [c.name for c in robot.coordinates]
    if not robot.loops:
        return (False,) * len(names)
    core = CoreDynamics(robot, may_be_singular=True)
    jacobians = [core.loop_jacobian(q) for q in islice(_closed_poses(robot), _POSES)]
    if not jacobians:
        raise InputError(f"robot {robot.name!r}: its loops cannot be closed near the initial pose")
    rank = max(int(np.linalg.matrix_rank(J, 1e-7 * np.linalg.norm(J))) for J in jacobians)
    if not required and max(np.linalg.norm(J) for J in jacobians) <= _NONE:
        return (False,) * len(names)  # the loops contain only fixed bodies
    preference = np.array([2.0 * (name in required) - 1.0 * (name in excluded) for name in names])
    sets = {tuple(sorted(_select_columns(J, rank, preference))) for J in jacobians}
    best = max(sorted(sets), key=lambda chosen: _conditioning(jacobians, chosen))
    required_indices = {names.index(n) for n in required if n in names}
    excluded_indices = {names.index(n) for n in excluded if n in names}
    if (
        _conditioning(jacobians[:1], best) <= _SHARE
        or not required_indices <= set(best)
        or excluded_indices & set(best)
    ):
        which = [f"{n} dependent" for n in required] + [f"{n} independent" for n in excluded]
        chosen = f" with {', '.join(which)}" if which else ""
        problem = "the loops do not allow it" if which else "the loops are in a singular pose"
        raise InputError(f"no set of independent coordinates exists{chosen}: {problem}")
    return tuple(k in best for k in range(len(names)))


def _closed_poses(robot: Robot) -> list[FloatArray]:
    """Return poses with closed loops: first near the initial pose, then within the limits."""
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


def _select_columns(J: FloatArray, rank: int, preference: FloatArray) -> list[int]:
    """Select well-conditioned columns of J by a greedy search."""
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


def _conditioning(jacobians: Sequence[FloatArray], chosen: Sequence[int]) -> float:
    """Return the conditioning of J_D at the first pose if it is poor there, else at the worst."""
    values = []
    for J in jacobians:
        sizes = np.linalg.svd(J[:, list(chosen)], compute_uv=False)
        most = np.linalg.norm(J, 2)
        least = sizes[-1] if len(sizes) == len(chosen) and len(sizes) else 0.0
        values.append(float(least / most) if most > 0.0 else 0.0)
    return values[0] if values[0] <= _POOR else max(_POOR, 1e-12) + min(values)
