"""Robot in OpenSim, from its .osim file."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.formats.opensim.write import write_osim
from addin_sdfusion.robot.formats.opensim.writing.names import with_legal_names
from sim_dart.core.arrays import FloatArray

with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)  # of its SWIG wrapper
    opensim: Any = pytest.importorskip(
        "opensim", reason="needs the extra opensim, which is for tests"
    )

opensim.Logger.setLevelString("Off")


def load(robot: Robot, folder: Path, **options: Any) -> tuple[Any, Any]:
    """Return the model and its initial state."""
    (file,) = write_osim(robot, folder, "robot", **options)
    model = opensim.Model(str(file))
    return model, model.initSystem()


class OpenSimRobot:
    """Terms of a model without forces; coordinates and muscles have the order of the robot."""

    def __init__(self, robot: Robot, folder: Path) -> None:
        legal = with_legal_names(robot)
        self.model, self.state = load(robot, folder)
        coordinates = self.model.getCoordinateSet()
        self.coordinates = [coordinates.get(c.name) for c in legal.coordinates]
        for k, coordinate in enumerate(self.coordinates):
            coordinate.setClamped(self.state, False)
            coordinate.setLocked(self.state, False)
            coordinate.setSpeedValue(self.state, float(k))
        self._order = np.argsort(_numbers(self.state.getU())).astype(int)
        self.model.realizeVelocity(self.state)
        self.paths = [
            opensim.GeometryPath.safeDownCast(
                self.model.getComponent(f"/forceset/{muscle.name}/path")
            )
            for muscle in legal.muscles
        ]

    def without_forces(self) -> None:
        """Disable muscles, motors, dampers and springs."""
        forces = self.model.getForceSet()
        for k in range(forces.getSize()):
            forces.get(k).setAppliesForce(self.state, False)

    def move(self, q: FloatArray, qd: FloatArray) -> None:
        """Set the state."""
        for coordinate, value, speed in zip(self.coordinates, q, qd, strict=True):
            coordinate.setValue(self.state, float(value), False)
            coordinate.setSpeedValue(self.state, float(speed))
        self.model.realizeVelocity(self.state)

    @property
    def mass_matrix(self) -> FloatArray:
        """Return M, shape (n, n)."""
        M = opensim.Matrix()
        self.model.getMatterSubsystem().calcM(self.state, M)
        n = len(self._order)
        values = np.array([[M.get(i, j) for j in range(n)] for i in range(n)]).reshape(n, n)
        return values[np.ix_(self._order, self._order)]

    @property
    def bias(self) -> FloatArray:
        """Return C + G plus the generalized forces of active elements, shape (n,)."""
        zero = opensim.Vector(len(self._order), 0.0)
        forces = opensim.InverseDynamicsSolver(self.model).solve(self.state, zero)
        return np.array(_numbers(forces))[self._order]

    @property
    def lengths(self) -> FloatArray:
        """Return the muscle lengths, shape (m,)."""
        return np.array([path.getLength(self.state) for path in self.paths])

    @property
    def moment_arms(self) -> FloatArray:
        """Return -L, shape (m, n)."""
        arms = [
            [path.computeMomentArm(self.state, c) for c in self.coordinates] for path in self.paths
        ]
        return np.array(arms).reshape(len(self.paths), len(self.coordinates))


def _numbers(vector: Any) -> list[float]:
    return [vector.get(k) for k in range(vector.size())]
