"""Robot dynamics computed by DART, with muscle paths and tasks from the C core."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Robot, TaskFrame
from sim_dart.core.arrays import FloatArray
from sim_dart.core.tasks import angle_bias
from sim_dart.dart.skeleton import build_skeleton

from .base import RobotDynamics


class DartDynamics(RobotDynamics):
    """Dynamics of a robot from DART (M, C, G, task bias) and the C core (l, L, y, J).

    Each instance has its own skeleton, so a controller does not change the state of a plant.

    Args:
        robot: The robot. Its active cable set and operational space are used.

    Raises:
        RobotError: The robot is not valid.
        InputError: Its mass matrix is singular.
    """

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot)
        self._skeleton = build_skeleton(robot)
        self._sprung = bool(self._stiffness.any())

    def _mass_matrix(self, q: FloatArray) -> FloatArray:
        self._skeleton.set_positions(q)
        return self._skeleton.matrix(self._skeleton.dart.getMassMatrix())

    def _coriolis(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        self._skeleton.set_positions(q)
        self._skeleton.set_velocities(qd)
        return self._skeleton.vector(self._skeleton.dart.getCoriolisForces())

    def _gravity(self, q: FloatArray) -> FloatArray:
        self._skeleton.set_positions(q)
        weight = self._skeleton.vector(self._skeleton.dart.getGravityForces())
        return weight + self._stiffness * (q - self._rest) if self._sprung else weight

    def _frame_biases(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        self._skeleton.set_positions(q)
        self._skeleton.set_velocities(qd)
        return np.array([self._frame_bias(frame) for frame in self.robot.task_frames]).reshape(-1)

    def _frame_bias(self, frame: TaskFrame) -> FloatArray:
        """Return the three values of a task frame in J' qd, at the current state of DART."""
        dart, body = self._skeleton.dart, self._skeleton.bodies[frame.link]
        velocities = dart.getVelocities()
        if not frame.is_orientation:
            J_rate = dart.getLinearJacobianDeriv(body, np.array(frame.position))
            return np.asarray(J_rate @ velocities, dtype=np.float64)
        from scipy.spatial.transform import Rotation  # imported late, since it takes 0.5 s

        angles = Rotation.from_matrix(body.getWorldTransform().rotation()).as_euler("XYZ")
        w = dart.getAngularJacobian(body) @ velocities
        return angle_bias(angles, w, dart.getAngularJacobianDeriv(body) @ velocities)
