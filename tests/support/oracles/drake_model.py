"""SDF of a robot in Drake."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.formats.sdf.write_joints import sdf_joints
from sim_dart.core.arrays import FloatArray


class DrakeRobot:
    """Dynamics of an SDF robot by Drake, which rejects files of which libsdformat only warns."""

    def __init__(self, robot: Robot, file: Path) -> None:
        self.plant: Any = MultibodyPlant(0.0)
        Parser(self.plant).AddModels(str(file))
        self.plant.mutable_gravity_field().set_gravity_vector(robot.gravity)
        self.plant.Finalize()
        self._context = self.plant.CreateDefaultContext()
        self._order = [self._dof(*mover) for mover in _movers(robot)]

    def move(self, q: FloatArray, qd: FloatArray) -> None:
        """Set the state."""
        positions, velocities = np.zeros((2, self.plant.num_velocities()))
        positions[self._order], velocities[self._order] = q, qd
        self.plant.SetPositions(self._context, positions)
        self.plant.SetVelocities(self._context, velocities)

    @property
    def mass_matrix(self) -> FloatArray:
        """Return M, shape (n, n)."""
        M = self.plant.CalcMassMatrix(self._context)
        return np.array(M[np.ix_(self._order, self._order)])

    @property
    def resistance(self) -> FloatArray:
        """Return C + G + D qd + K (q - rest), shape (n,)."""
        forces = MultibodyForces(self.plant)
        self.plant.CalcForceElementsContribution(self._context, forces)
        rest = np.zeros(self.plant.num_velocities())
        return np.array(self.plant.CalcInverseDynamics(self._context, rest, forces))[self._order]

    def _dof(self, joint: str, place: int) -> int:
        return int(self.plant.GetJointByName(joint).velocity_start()) + place


def _movers(robot: Robot) -> list[tuple[str, int]]:
    """Return the SDF joint of each coordinate, and its index in this joint."""
    written, movers = sdf_joints(robot), []
    for joint in robot.joints:
        places = [(part.name, k) for part in written[joint.name] for k in range(len(part.motions))]
        driven = {motion.coordinate: places[k] for k, motion in enumerate(joint.motions)}
        movers += [driven[k] for k in range(len(joint.coordinates))]
    return movers
