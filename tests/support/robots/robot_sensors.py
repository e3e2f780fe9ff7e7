"""Simulated sensors of a robot, in C."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, library
from sim_dart.estimation.estimated_robot import cable_compliances, estimated_robot
from sim_dart.estimation.imu_frames import imu_frames
from sim_dart.estimation.sensors import SensorSettings
from sim_dart.estimation.settings import Imu


class RobotSensors:
    """Binding of sim_dart/csrc/sensors/sensors.h.

    Args:
        robot: The simulated robot.
        settings: Errors of the sensors.
        imus: IMUs on moving links.

    Attributes:
        q, qd: Ground truth of the state, shape (n,), to be written before a measurement.
        tensions: True tensions, shape (m,), in [N].
        readings: Measurements, shape (channels,), as a view.
        remembered: The complete state, as a view.
    """

    def __init__(
        self, robot: Robot, settings: SensorSettings | None = None, imus: Sequence[Imu] = ()
    ) -> None:
        settings = settings or SensorSettings()
        c, pointer, size, count = library(), ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int32
        c.sensors_size.argtypes, c.sensors_size.restype = [pointer, count, count], size
        c.sensors_open.argtypes = [pointer, count, pointer, count, pointer]
        c.sensors_open.restype = pointer
        c.sensors_array.argtypes = [pointer, ctypes.c_char_p, ctypes.POINTER(size)]
        c.sensors_array.restype = ctypes.POINTER(ctypes.c_double)
        c.sensors_reset.argtypes = [pointer]
        c.sensors_read.argtypes = [pointer, ctypes.c_double]
        self._core, self._places = (
            Core(compile_blob(estimated_robot(robot))),
            imu_frames(robot, imus),
        )
        sizes, core = (len(imus), settings.delay), self._core.handle
        self._c, self._memory = c, np.empty(-(-c.sensors_size(core, *sizes) // 8))
        places = self._places.frames.ctypes.data, settings.delay, self._memory.ctypes.data
        self._handle = ctypes.c_void_p(c.sensors_open(core, len(imus), *places))
        for name in ("noise", "resolution", "offset", "stuck", "seed"):
            self._array(name)[:] = getattr(settings, name)
        self._array("compliance")[:] = cable_compliances(robot)
        self._array("imu_rotation")[:] = self._places.rotations.ravel()
        self._array("imu_position")[:] = self._places.positions.ravel()
        self.q, self.qd, self.tensions = (self._array(name) for name in ("q", "qd", "tensions"))
        self.readings, self.remembered = self._array("readings"), self._array("remembered")
        self.reset()

    def reset(self) -> None:
        """Reset the sensors to the first measurement."""
        self._c.sensors_reset(self._handle)

    def read(self, h: float) -> int:
        """Measure, h [s] after the last measurement.

        Returns:
            0, or the number of the first coordinate whose true state is not finite.
        """
        bad: int = self._c.sensors_read(self._handle, h)
        return bad

    def _array(self, name: str) -> FloatArray:
        length = ctypes.c_size_t()
        pointer = self._c.sensors_array(self._handle, name.encode(), ctypes.byref(length))
        return np.ctypeslib.as_array(pointer, (length.value,))
