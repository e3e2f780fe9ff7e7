"""Sensors of a robot, in C: noise, resolution, offsets, delay."""

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
from .settings import InertialUnit
from .unit_places import unit_places

CHANNELS = ("length", "tension", "torque", "encoder", "gyroscope", "accelerometer")
"""Kinds of readings, in their order."""

MAX_DELAY = 100_000
"""In readings, as sensors.c has it."""


@dataclass(frozen=True)
class SensorSettings:
    """How good sensors are.

    Each is a number for all readings, or an array of shape (channels,) in the order of `CHANNELS`:
    m lengths and m tensions, n torques and n encoders, three axes of each gyroscope, and of each
    accelerometer. Units are those of the readings: [m], [N], [N·m], [rad], [rad/s], [m/s²].

    Attributes:
        noise: Standard deviation of normally distributed noise.
        resolution: 0 for none.
        offset: Added to the true value.
        stuck: Time from which a channel repeats itself, in [s].
        delay: In readings, of all channels.
        seed: Of the noise.
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
    """What sensors read of a robot; see `sim_dart/csrc/sensors/sensors.h`.

    Args:
        robot: The robot as it is.
        settings: How good they are.
        units: Inertial units on links that move.

    Raises:
        InputError: A setting does not fit the robot.
        UnknownNameError: There is no such link.

    Attributes:
        q, qd: The true state, shape (n,); to be written before a reading, as the next ones are.
        tensions: Shape (m,), in [N].
        torques: Of motors at joints, shape (n,).
        readings: Shape (channels,); a view, which a reading changes.
    """

    def __init__(
        self,
        robot: Robot,
        settings: SensorSettings | None = None,
        units: Sequence[InertialUnit] = (),
    ) -> None:
        settings = settings or SensorSettings()
        if not 0 <= settings.delay <= MAX_DELAY:
            raise InputError(
                f"delay must be from 0 to {MAX_DELAY} measurements: {settings.delay!r}"
            )
        self._robot, self._core = robot, Core(compile_blob(estimated_robot(robot)))
        n, m, i = len(robot.coordinates), len(robot.muscles), len(units)
        c, self._places = _bound(), unit_places(robot, units)
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
                what = f"{name} must be one number or {target.size}, not {value!r}"
                raise InputError(what) from None
        self.reset()

    def array(self, name: str, *shape: int) -> FloatArray:
        """Return a view of an array of the C library, see sensors.h, of the given shape."""
        length = ctypes.c_size_t()
        pointer = self._c.sensors_array(self._handle, name.encode(), ctypes.byref(length))
        assert pointer, name
        address = ctypes.cast(pointer, ctypes.c_void_p).value or 0
        first = (address - self._memory.ctypes.data) // 8
        return self._memory[first : first + length.value].reshape(shape)

    def reset(self) -> None:
        """Back to the first reading."""
        self._c.sensors_reset(self._handle)

    def read(self, h: float) -> None:
        """Read, h [s] after the last reading.

        Raises:
            SimulationError: The true state is not finite.
        """
        bad = self._c.sensors_read(self._handle, h)
        if bad:
            name = self._robot.coordinates[bad - 1].name
            raise SimulationError(f"sensors cannot read: {name} or its rate is not finite")

    def get_state(self) -> FloatArray:
        """Return all that they remember, for `set_state`."""
        return self._remembered.copy()

    def set_state(self, state: FloatArray) -> None:
        """Go back to a state from `get_state`."""
        self._remembered[:] = state
