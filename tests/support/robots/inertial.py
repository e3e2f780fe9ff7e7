"""IMU measurements by differences of link poses, as a reference."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart import compile_blob
from sim_dart.core.arrays import FloatArray
from sim_dart.core.frames import moving_frames, transform
from sim_dart.core.library import Core
from sim_dart.estimation.settings import Imu

_D = 1e-4  # in [s]


class UnitReadings:
    """Angular velocity and specific force of IMUs on links, in the axes of the IMUs."""

    def __init__(self, robot: Robot, units: list[Imu]) -> None:
        self._core, self._units = Core(compile_blob(robot)), units
        self._places = moving_frames(robot)[1]
        self._rotation = self._core.array("frame_rotation", -1, 3, 3)
        self._origin = self._core.array("frame_origin", -1, 3)
        self._gravity = np.array(robot.gravity)

    def read(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """Return the measurements, shape (units, 2, 3), in [rad/s] and [m/s²]."""
        return np.array([self._of(unit, q, qd, qdd) for unit in self._units])

    def _of(
        self, unit: Imu, q: FloatArray, qd: FloatArray, qdd: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        before, now, after = (
            self._pose(unit, q + qd * t + 0.5 * qdd * t * t) for t in (-_D, 0.0, _D)
        )
        R = now[:3, :3]
        W = R.T @ (after - before)[:3, :3] / (2 * _D)
        a = (after - 2 * now + before)[:3, 3] / _D**2
        w = 0.5 * np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]])
        return w, R.T @ (a - self._gravity)

    def _pose(self, unit: Imu, q: FloatArray) -> FloatArray:
        self._core.move(self._core.handle, np.ascontiguousarray(q).tobytes())
        place, T = self._places[unit.link], np.eye(4)
        T[:3, :3], T[:3, 3] = self._rotation[place.frame], self._origin[place.frame]
        return T @ place.T_frame_link @ transform(unit.pose)
