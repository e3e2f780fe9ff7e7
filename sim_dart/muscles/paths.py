"""Muscle path lengths l and muscle Jacobian L = dl/dq, computed by the C core."""

from __future__ import annotations

from typing import NamedTuple

from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.checks.check import require_valid
from addin_sdfusion.robot.model.muscle_laws import states_of
from sim_dart.core.arrays import FloatArray, vector
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core
from sim_dart.core.tasks import point_rows, task_rows

from .friction import bend_count, has_cable_friction, stretch_count
from .path_shapes import PathShapes, PointForces


class PathState(NamedTuple):
    """Lengths and Jacobian at one q, as views that the next evaluation overwrites.

    Attributes:
        lengths: Path lengths l, shape (m,), in [m].
        jacobian: L = dl/dq, shape (m, n), in [m/rad] or [m/m]; positive if the muscle lengthens.
    """

    lengths: FloatArray
    jacobian: FloatArray


class MusclePaths:
    """Muscle paths of the active cable set of a robot.

    All methods accept joint positions q, shape (n,), in [rad] or [m], and raise InputError for
    another shape.

    Raises:
        RobotError: The robot is not valid.

    Attributes:
        core: The core of this robot.
        has_friction: Whether any cable has friction.
        coordinates: Number of coordinates n.
        bends: Number of bends with friction.
        law_states: Number of states of the muscle laws.
    """

    def __init__(self, robot: Robot) -> None:
        require_valid(robot)
        n, m = len(robot.coordinates), len(robot.muscles)
        self._n = n
        self.core = self._core = Core(compile_blob(robot))
        self._move = self._core.move
        self._handle = self._core.handle
        self._state = PathState(self._core.array("lengths", m), self._core.array("jacobian", m, n))
        self.has_friction, self.coordinates = has_cable_friction(robot), n
        self.bends = sum(bend_count(muscle) for muscle in robot.muscles)
        self.law_states = sum(len(states_of(m.model)) + stretch_count(m) for m in robot.muscles)
        self._pulling = (
            self._core.array("pull_jacobian", m, n) if self.has_friction else self._state.jacobian
        )
        self._shapes = PathShapes(robot, self._core)
        k = len(robot.task_frames)
        self._task_rows = task_rows(robot)
        self._point_rows = point_rows(robot)
        self._task_values = self._core.array("task_values", 3 * k)
        self._task_jacobian = self._core.array("task_jacobian", 3 * k, n)

    def evaluate(self, q: ArrayLike) -> PathState:
        """Return lengths and Jacobian at q, as views that the next call overwrites."""
        self._move(self._handle, vector("q", q, self._n).tobytes())
        return self._state

    def pulling(self, q: ArrayLike) -> FloatArray:
        """Return P(q) of tau = -P'f, shape (m, n), as a view that the next call overwrites.

        Without cable friction P equals L. With friction, P includes the force ratios at the bends,
        which depend on the slip states of `CableSlip`.
        """
        L = self.evaluate(q).jacobian
        if not self.has_friction:
            return L
        self._core.update_pulling(self._handle)
        return self._pulling

    def path_points(self, q: ArrayLike) -> list[FloatArray]:
        """Return a polyline along each muscle path for drawing, each of shape (k, 3), in [m]."""
        self.evaluate(q)
        return self._shapes.lines()

    def point_forces(self, q: ArrayLike, forces: ArrayLike) -> PointForces:
        """Return the forces of the muscles on links at via points, wrap surfaces and pulleys.

        The forces are in world axes. Their power equals the power of -L'f. Every straight segment
        of a path has two opposite forces along the segment.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            forces: Tensions f, shape (m,), in [N].
        """
        tensions = vector("forces", forces, self._state.lengths.size)
        self.evaluate(q)
        return self._shapes.forces(tensions)

    def task_position(self, q: ArrayLike) -> FloatArray:
        """Return the task coordinates y(q), shape (k,), in [m] or [rad]."""
        self.evaluate(q)
        return self._task_values[self._task_rows]

    def task_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return J = dy/dq, shape (k, n), rows in [m] or [rad] per [rad] or [m]."""
        return self._frame_jacobian(q)[self._task_rows]

    def point_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return the linear Jacobians of the position task frames, world axes, shape (3 p, n)."""
        return self._frame_jacobian(q)[self._point_rows]

    def _frame_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return the Jacobian of all task frames, three rows per frame, as a view."""
        self.evaluate(q)
        self._core.update_task_jacobian(self._handle)
        return self._task_jacobian
