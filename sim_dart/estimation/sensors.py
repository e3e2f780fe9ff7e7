"""Simulated sensors of a robot, implemented in C: noise, resolution, offsets and delay."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Robot, SimulationError
from sim_dart.core.arrays import FloatArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, library

from .estimated_robot import cable_compliances, estimated_robot
from .imu_frames import imu_frames
from .settings import Imu

CHANNELS = ("length", "tension", "torque", "encoder", "gyroscope", "accelerometer")
"""Kinds of measurements, in the order of the channels."""

MAX_DELAY = 100_000
"""Largest delay in measurements, as in sensors.c."""


@dataclass(frozen=True)
class SensorSettings:
    """Errors of simulated sensors.

    Each attribute is a number for all channels, or an array of shape (channels,) in the order of
    `CHANNELS`: m lengths, m tensions, n torques, n encoders, three axes of each gyroscope and three
    axes of each accelerometer. Units are [m], [N], [N·m], [rad], [rad/s] and [m/s²].

    Attributes:
        noise: Standard deviation of Gaussian noise.
        resolution: Resolution, 0 for no rounding.
        offset: Offset that is added to the true value.
        stuck: Time after which a channel keeps its last value, in [s].
        delay: Delay of all channels, as a number of measurements.
        seed: Random seed of the noise.
    """

    noise: ArrayLike = 0.0
    resolution: ArrayLike = 0.0
    offset: ArrayLike = 0.0
    stuck: ArrayLike = np.inf
    delay: int = 0
    seed: int = 0


@cache
def _bound() -> Any:
    core = library()
    pointer, size, count = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int32
    core.sensors_size.argtypes = [pointer, count, count]
    core.sensors_size.restype = size
    core.sensors_open.argtypes = [pointer, count, pointer, count, pointer]
    core.sensors_open.restype = pointer
    core.sensors_array.argtypes = [pointer, ctypes.c_char_p, ctypes.POINTER(size)]
    core.sensors_array.restype = ctypes.POINTER(ctypes.c_double)
    core.sensors_reset.argtypes = [pointer]
    core.sensors_reset.restype = None
    core.sensors_read.argtypes = [pointer, ctypes.c_double]
    return core


class RobotSensors:
    """Simulated sensors of a robot; see `sim_dart/csrc/sensors/sensors.h`.

    Args:
        robot: The simulated robot.
        settings: Errors of the sensors.
        imus: IMUs on moving links.

    Raises:
        InputError: A setting does not fit the robot.
        UnknownNameError: A link does not exist.

    Attributes:
        q, qd: Ground truth of the state, shape (n,). Write this and the next two attributes before
            each measurement.
        tensions: True tensions, shape (m,), in [N].
        torques: Torques of joint motors, shape (n,), in [N·m] or [N].
        readings: Measurements, shape (channels,), as a view.
    """

    def __init__(
        self,
        robot: Robot,
        settings: SensorSettings | None = None,
        imus: Sequence[Imu] = (),
    ) -> None:
        settings = settings or SensorSettings()
        if not 0 <= settings.delay <= MAX_DELAY:
            raise InputError(
                f"delay must be from 0 to {MAX_DELAY} measurements: {settings.delay!r}"
            )
        self._robot, self._core = robot, Core(compile_blob(estimated_robot(robot)))
        n, m, i = len(robot.coordinates), len(robot.muscles), len(imus)
        c, self._places = _bound(), imu_frames(robot, imus)
        self._c = c
        sizes = i, settings.delay
        self._memory = np.empty(-(-c.sensors_size(self._core.handle, *sizes) // 8))
        self._handle = ctypes.c_void_p(
            c.sensors_open(
                self._core.handle,
                i,
                self._places.frames.ctypes.data,
                settings.delay,
                self._memory.ctypes.data,
            )
        )
        self.q, self.qd = self.array("q", n), self.array("qd", n)
        self.tensions, self.torques = self.array("tensions", m), self.array("torques", n)
        self.readings, self._remembered = self.array("readings", -1), self.array("remembered", -1)
        values = {name: getattr(settings, name) for name in ("noise", "resolution", "offset")}
        values |= {"stuck": settings.stuck, "seed": settings.seed}
        values |= {"compliance": cable_compliances(robot)}
        values |= {"imu_rotation": self._places.rotations.ravel()}
        values |= {"imu_position": self._places.positions.ravel()}
        for name, value in values.items():
            target = self.array(name, -1)
            try:
                target[:] = value
            except (TypeError, ValueError):
                problem = f"{name} must be one number or {target.size}, not {value!r}"
                raise InputError(problem) from None
        self.reset()

    def array(self, name: str, *shape: int) -> FloatArray:
        """Return an array of the C library (see sensors.h) as a view of the given shape."""
        length = ctypes.c_size_t()
        pointer = self._c.sensors_array(self._handle, name.encode(), ctypes.byref(length))
        assert pointer, name
        address = ctypes.cast(pointer, ctypes.c_void_p).value or 0
        first = (address - self._memory.ctypes.data) // 8
        return self._memory[first : first + length.value].reshape(shape)

    def reset(self) -> None:
        """Reset the sensors to the first measurement."""
        self._c.sensors_reset(self._handle)

    def read(self, h: float) -> None:
        """Measure, h [s] after the last measurement.

        Raises:
            SimulationError: The true state is not finite.
        """
        bad = self._c.sensors_read(self._handle, h)
        if bad:
            name = self._robot.coordinates[bad - 1].name
            raise SimulationError(f"sensors: {name} or its rate is not finite")

    def get_state(self) -> FloatArray:
        """Return the complete state of the sensors, for `set_state`."""
        return self._remembered.copy()

    def set_state(self, state: FloatArray) -> None:
        """Restore a state from `get_state`."""
        self._remembered[:] = state
