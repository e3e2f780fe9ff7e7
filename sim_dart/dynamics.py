"""DartDynamics: the terms of M qdd + C + G = -L^T f + A tau at any (q, qd), for controllers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from addin_sdfusion.robot import Robot, TaskFrame

from .muscle_paths import MusclePaths, finite, vector
from .skeleton import build_skeleton
from .tasks import angle_bias, task_rows

FloatArray = NDArray[np.float64]


class DartDynamics:
    """Dynamics of a robot, from DART (M, C, G, task bias) and the C core (l, L, y, J).

    It owns its skeleton, so a controller never disturbs a plant. Joint damping is not part of these
    terms; `damping` gives it apart. Every array returned is the caller's own.

    Args:
        robot: The robot; its active cable set and operational space count.

    Raises:
        RobotError: The robot is not valid.

    Attributes:
        robot: The robot.
        n: Number of coordinates.
        m: Number of muscles.
        f_min, f_max: Force bounds, shape (m,), in [N].
        damping: Viscous joint damping, shape (n,), in [N·m·s/rad] or [N·s/m].
        q_min, q_max: Joint limits, shape (n,), in [rad] or [m]; infinite where there is none.
        actuation: A, which gives motors of the joints their coordinates, shape (n, actuated).
        task_names: k names, in the order of y, such as `hand.x`.
        task_angles: Which task coordinates are angles, shape (k,).
    """

    def __init__(self, robot: Robot) -> None:
        self._paths = MusclePaths(robot)
        self._skeleton = build_skeleton(robot)
        self.robot = robot
        self.coordinate_names = tuple(c.name for c in robot.coordinates)
        self.muscle_names = tuple(muscle.name for muscle in robot.muscles)
        self.n = len(self.coordinate_names)
        self.m = len(self.muscle_names)
        self.f_min = np.array([muscle.f_min for muscle in robot.muscles])
        self.f_max = np.array([muscle.f_max for muscle in robot.muscles])
        self.damping = np.array([c.damping for c in robot.coordinates])
        self._stiffness = np.array([c.stiffness for c in robot.coordinates])
        self._rest = np.array([c.rest for c in robot.coordinates])
        self._sprung = bool(self._stiffness.any())
        self.actuation = np.eye(self.n)[:, [c.actuated for c in robot.coordinates]]
        self.q_min = np.array([c.lower for c in robot.coordinates])
        self.q_max = np.array([c.upper for c in robot.coordinates])
        frames = [(frame, axis) for frame in robot.task_frames for axis in frame.axes]
        self.task_names = tuple(f"{frame.name}.{axis}" for frame, axis in frames)
        self.task_angles = np.array([frame.is_orientation for frame, _ in frames], dtype=bool)
        self._task_rows = task_rows(robot)

    def mass_matrix(self, q: ArrayLike) -> FloatArray:
        """M(q), shape (n, n), in [kg·m²] for revolute and [kg] for prismatic coordinates.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        self._move(q)
        return self._skeleton.matrix(self._skeleton.dart.getMassMatrix())

    def coriolis(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """C(q, qd), the velocity terms as a vector, shape (n,), in [N·m] or [N].

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        """
        self._move(q, qd)
        return self._skeleton.vector(self._skeleton.dart.getCoriolisForces())

    def gravity(self, q: ArrayLike) -> FloatArray:
        """G(q) = dV/dq, of the weight and of the joints' springs, shape (n,), in [N·m] or [N].

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        self._move(q)
        weight = self._skeleton.vector(self._skeleton.dart.getGravityForces())
        if not self._sprung:
            return weight
        springs: FloatArray = self._stiffness * (vector("q", q, self.n) - self._rest)
        return weight + springs

    def muscle_lengths(self, q: ArrayLike) -> FloatArray:
        """l(q), shape (m,), in [m].

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        return self._paths.evaluate(q).lengths.copy()

    def muscle_jacobian(self, q: ArrayLike) -> FloatArray:
        """L(q) = dl/dq, shape (m, n), in [m/rad] or [m/m].

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        return self._paths.evaluate(q).jacobian.copy()

    def task_position(self, q: ArrayLike) -> FloatArray:
        """Task coordinates y(q), shape (k,), in [m] or [rad]: the active frames' axes, in order.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        return self._paths.task_position(q)

    def task_jacobian(self, q: ArrayLike) -> FloatArray:
        """J(q) = dy/dq, shape (k, n): y' = J q' for positions and angles alike.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        return self._paths.task_jacobian(q)

    def point_jacobian(self, q: ArrayLike) -> FloatArray:
        """Linear Jacobians of the task frames that are points, shape (3 p, n), world axes.

        Its transpose makes generalised forces of forces on these points, whichever of their axes
        count in y.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        return self._paths.point_jacobian(q)

    def task_bias(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """J'(q, qd) qd, shape (k,), in [m/s²] or [rad/s²].

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        """
        self._move(q, qd)
        terms = [self._frame_bias(frame) for frame in self.robot.task_frames]
        return np.array(terms).reshape(-1)[self._task_rows]

    def _frame_bias(self, frame: TaskFrame) -> FloatArray:
        """The three values of a task frame in J' qd, at DART's present state."""
        dart, body = self._skeleton.dart, self._skeleton.bodies[frame.link]
        velocities = dart.getVelocities()
        if not frame.is_orientation:
            bias: FloatArray = (
                dart.getLinearJacobianDeriv(body, np.array(frame.position)) @ velocities
            )
            return bias
        R = body.getWorldTransform().rotation()
        angles = Rotation.from_matrix(R).as_euler("XYZ")
        w = dart.getAngularJacobian(body) @ velocities
        return angle_bias(angles, w, dart.getAngularJacobianDeriv(body) @ velocities)

    def _move(self, q: ArrayLike, qd: ArrayLike | None = None) -> None:
        self._skeleton.set_positions(finite("q", vector("q", q, self.n)))
        if qd is not None:
            self._skeleton.set_velocities(finite("qd", vector("qd", qd, self.n)))
