"""Base class of robot dynamics for controllers, independent of the engine."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray, finite
from sim_dart.core.loop_fields import closures
from sim_dart.core.tasks import task_rows
from sim_dart.muscles.cable_slip import CableSlip
from sim_dart.muscles.paths import MusclePaths


class RobotDynamics(ABC):
    """Terms of the equations of motion M qdd + C + G = -L'f + A tau of a robot.

    Joint damping is not part of these terms; see `damping`. The methods accept joint positions q,
    shape (n,), in [rad] or [m], and joint velocities qd, shape (n,), in [rad/s] or [m/s]. They
    raise InputError for another shape or values that are not finite. All returned arrays are
    copies.

    Args:
        robot: The robot. Its active cable set and operational space are used.

    Raises:
        RobotError: The robot is not valid.
        InputError: Its mass matrix is singular.

    Attributes:
        n: Number of coordinates.
        m: Number of muscles.
        motor_names: Names of the coordinates that have motors, in the order of q.
        f_min, f_max: Force limits of the muscles, in [N], followed by the torque limits of the
            motors, in [N·m] or [N], shape (m + motors,).
        damping: Viscous joint damping, shape (n,), in [N·m·s/rad] or [N·s/m].
        q_min, q_max: Joint limits, shape (n,), in [rad] or [m]; infinite if unlimited.
        actuation: Matrix A, which maps motor torques to coordinates, shape (n, motors).
        task_names: Names of the k task coordinates, in the order of y, such as `hand.x`.
        task_angles: Flags of the task coordinates that are angles, shape (k,).
    """

    def __init__(self, robot: Robot) -> None:
        self._paths = MusclePaths(robot)
        self.robot = robot
        self.coordinate_names = tuple(c.name for c in robot.coordinates)
        self.muscle_names = tuple(muscle.name for muscle in robot.muscles)
        self.n = len(self.coordinate_names)
        self.m = len(self.muscle_names)
        self.motor_names = tuple(motor.name for motor in robot.motors)
        self.f_min = np.array(
            [*(muscle.f_min for muscle in robot.muscles), *(c.tau_min for c in robot.motors)]
        )
        self.f_max = np.array(
            [*(muscle.f_max for muscle in robot.muscles), *(c.tau_max for c in robot.motors)]
        )
        self.damping = np.array([c.damping for c in robot.coordinates])
        self.actuation = np.eye(self.n)[:, [c.actuated for c in robot.coordinates]]
        self.q_min = np.array([c.lower for c in robot.coordinates])
        self.q_max = np.array([c.upper for c in robot.coordinates])
        frames = [(frame, axis) for frame in robot.task_frames for axis in frame.axes]
        self.task_names = tuple(f"{frame.name}.{axis}" for frame, axis in frames)
        self.task_angles = np.array([frame.is_orientation for frame, _ in frames], dtype=bool)

        self._stiffness = np.array([c.stiffness for c in robot.coordinates])
        self._rest = np.array([c.rest for c in robot.coordinates])
        self._task_rows = task_rows(robot)

    def mass_matrix(self, q: ArrayLike) -> FloatArray:
        """Return M(q), shape (n, n), in [kg·m²] for rotations and [kg] for translations."""
        return self._mass_matrix(finite("q", q, self.n))

    def coriolis(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """Return C(q, qd), the vector of velocity terms, shape (n,), in [N·m] or [N]."""
        return self._coriolis(finite("q", q, self.n), finite("qd", qd, self.n))

    def gravity(self, q: ArrayLike) -> FloatArray:
        """Return G(q) = dV/dq of the weight and the joint springs, shape (n,), in [N·m] or [N]."""
        return self._gravity(finite("q", q, self.n))

    def task_bias(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """Return the bias J'(q, qd) qd of the task, shape (k,), in [m/s²] or [rad/s²]."""
        core = self._paths.core
        core.move(core.handle, finite("q", q, self.n).tobytes())
        core.update_task_bias(core.handle, finite("qd", qd, self.n).tobytes())
        biases = core.array("task_bias", 3 * len(self.robot.task_frames))
        return biases[self._task_rows]

    @abstractmethod
    def _mass_matrix(self, q: FloatArray) -> FloatArray: ...

    @abstractmethod
    def _coriolis(self, q: FloatArray, qd: FloatArray) -> FloatArray: ...

    @abstractmethod
    def _gravity(self, q: FloatArray) -> FloatArray: ...

    def loop_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return J(q) of the loop constraints J qd = 0, shape (c, n). Rows may be dependent."""
        return self._closures(q, np.zeros(self.n))[0].copy()

    def loop_bias(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """Return J'(q, qd) qd of the loop constraints J qdd = -J' qd, shape (c,)."""
        return self._closures(q, finite("qd", qd, self.n))[1].copy()

    def _closures(self, q: ArrayLike, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        core, count = self._paths.core, len(closures(self.robot))
        core.move(core.handle, finite("q", q, self.n).tobytes())
        core.closures(core.handle, qd.tobytes())
        J = core.array("closure_jacobian", count, self.n)
        return J, core.array("closure_bias", count)

    @property
    def cable_slip(self) -> CableSlip | None:
        """Slip states that `actuator_jacobian` uses, or None without cable friction."""
        return CableSlip(self._paths) if self._paths.has_friction else None

    def muscle_lengths(self, q: ArrayLike) -> FloatArray:
        """Return the path lengths l(q), shape (m,), in [m]."""
        return self._paths.evaluate(q).lengths.copy()

    def muscle_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return the muscle Jacobian L(q) = dl/dq, shape (m, n), in [m/rad] or [m/m]."""
        return self._paths.evaluate(q).jacobian.copy()

    def actuator_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return L(q) followed by a row for each motor, shape (m + motors, n).

        With f, the muscle forces followed by the motor torques, the generalised force is -L'f.
        With cable friction, P(q) of `MusclePaths.pulling` replaces L(q); see `cable_slip`.
        """
        L = self._paths.pulling(q)
        return np.concatenate([L, -self.actuation.T]) if self.motor_names else L.copy()

    def task_position(self, q: ArrayLike) -> FloatArray:
        """Return the task coordinates y(q), shape (k,), in [m] or [rad]."""
        return self._paths.task_position(q)

    def task_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return the task Jacobian J(q) = dy/dq for positions and angles, shape (k, n)."""
        return self._paths.task_jacobian(q)

    def point_jacobian(self, q: ArrayLike) -> FloatArray:
        """Return the linear Jacobians of the position task frames, world axes, shape (3 p, n).

        The transpose maps forces on these points to generalised forces. All three axes of a point
        are included, even if y contains only some of them.
        """
        return self._paths.point_jacobian(q)
