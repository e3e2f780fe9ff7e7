"""DartDynamics: the terms of M qdd + C + G = -L^T f + A tau at any (q, qd), for controllers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from addin_sdfusion.robot import Robot, TaskFrame
from sim_dart.core.arrays import FloatArray
from sim_dart.core.tasks import angle_bias, task_rows
from sim_dart.dart.skeleton import build_skeleton
from sim_dart.muscles.paths import finite, vector

from .base import RobotTerms


class DartDynamics(RobotTerms):
    """Dynamics of a robot, from DART (M, C, G, task bias) and the C core (l, L, y, J).

    It owns its skeleton, so a controller never disturbs a plant. Joint damping is not part of these
    terms; `damping` gives it apart. Every array returned is the caller's own.

    Args:
        robot: The robot; its active cable set and operational space count.

    Raises:
        RobotError: The robot is not valid.
    """

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot)
        self._skeleton = build_skeleton(robot)
        self._stiffness = np.array([c.stiffness for c in robot.coordinates])
        self._rest = np.array([c.rest for c in robot.coordinates])
        self._sprung = bool(self._stiffness.any())
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
