"""Robot dynamics computed by DART, with muscle paths and tasks from the C core."""

from __future__ import annotations

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.dart.skeleton import build_skeleton

from .base import RobotDynamics


class DartDynamics(RobotDynamics):
    """Dynamics of a robot from DART (M, C, G) and the C core (muscle paths and tasks).

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
