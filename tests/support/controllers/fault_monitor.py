"""The monitor of faults in C, and sensors of a robot with constant moment arms."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from typing import Any

import numpy as np

from controllers.arrays import FloatArray
from controllers.qp.dual_newton import library

STEP = 0.005  # in [s]
NOISE = 1e-4  # of lengths in [m] and encoders in [rad]
KINDS = (
    *("none", "broken", "jammed", "weak", "length_stuck", "length_bias", "length_scale"),
    *("length_swapped", "tension_stuck", "tension_dead", "encoder_stuck"),
)


class FaultMonitor:
    """Binding of controllers/csrc/faults/faults.h, with settings of noisy sensors.

    Args:
        n: Number of coordinates.
        m: Number of muscles.
        rate: Accepted number of false alarms per hour.
    """

    def __init__(self, n: int, m: int, rate: float = 0.1) -> None:
        c, pointer, size = library(), ctypes.c_void_p, ctypes.c_size_t
        c.faults_size.restype, c.faults_open.restype = size, pointer
        c.faults_open.argtypes = [ctypes.c_int, ctypes.c_int, pointer]
        c.faults_array.restype = ctypes.POINTER(ctypes.c_double)
        c.faults_array.argtypes = [pointer, ctypes.c_char_p, ctypes.POINTER(size)]
        c.faults_reset.argtypes = c.faults_pose.argtypes = [pointer]
        c.faults_tick.argtypes = [pointer, ctypes.c_double]
        c.faults_move.argtypes = [pointer, ctypes.c_double, ctypes.c_int]
        self.n, self.m, self._c = n, m, c
        self._memory = np.zeros(c.faults_size(n, m) // 8 + 1)
        self._handle = c.faults_open(n, m, self._memory.ctypes.data)
        self.write(
            false_alarms_per_hour=rate,
            length_noise=NOISE,
            encoder_noise=NOISE,
            tension_noise=0.1,
            tension_error=0.05,
            force_rate=np.inf,
            f_max=500.0,
        )
        self.reset()

    def array(self, name: str) -> FloatArray:
        """Return an array of the monitor as a view."""
        length = ctypes.c_size_t()
        pointer = self._c.faults_array(self._handle, name.encode(), ctypes.byref(length))
        return np.ctypeslib.as_array(pointer, (length.value,))

    def write(self, **values: Any) -> None:
        """Write arrays by name."""
        for name, value in values.items():
            self.array(name)[:] = np.ravel(value)

    def reset(self) -> None:
        """Forget all faults."""
        self._c.faults_reset(self._handle)

    def fit_pose(self) -> bool:
        """Return whether q is near the fit of lengths and encoders; otherwise, move it there."""
        return self._c.faults_pose(self._handle) == 0

    def tick(self) -> int:
        """Process the inputs and return the number of parts with faults.

        Geometry is linear up to the pose.
        """
        before = self.array("q").copy()
        if not self.fit_pose():
            jacobian = self.array("jacobian").reshape(self.m, self.n)
            self.array("path_lengths")[:] += jacobian @ (self.array("q") - before)
            assert self.fit_pose()
        count: int = self._c.faults_tick(self._handle, STEP)
        return count

    def move(self, steps: int) -> int:
        """Process the motion of the last tick and return the number of parts with faults."""
        count: int = self._c.faults_move(self._handle, STEP, steps)
        return count

    @property
    def found(self) -> dict[str, int]:
        """Part number of each kind that was found; the last one if several exist."""
        kinds = self.array("kind")
        return {KINDS[int(kinds[p])]: int(p) for p in np.flatnonzero(kinds)}


class Bench:
    """Sensors of a robot with constant moment arms, which moves on sines.

    Args:
        seed: Seed of moment arms, motion and noise.

    Attributes:
        n, m: Number of coordinates and muscles.
        lengths, encoders, tensions, commands: The newest measurements and commands.
        tick: Number of the tick.
    """

    n, m = 3, 8

    def __init__(self, seed: int = 0) -> None:
        self._random = np.random.default_rng(seed)
        self.L = self._random.uniform(-0.06, 0.06, (self.m, self.n))
        self._rest = self._random.uniform(0.3, 0.6, self.m)
        self._phase = self._random.uniform(0.0, 6.0, self.n)

    def ticks(self, count: int, jump: int = -1) -> Iterator[Bench]:
        """Yield itself with the measurements of each tick.

        Args:
            count: Number of ticks.
            jump: Tick from which an unknown load shifts the pose by 0.02 rad.
        """
        for self.tick in range(count):
            t = self.tick * STEP
            self.q = 0.4 * np.sin(2.0 * t + self._phase)
            if 0 <= jump <= self.tick:
                self.q = self.q + 0.02
            self.commands = 60.0 + 40.0 * np.sin(1.5 * t + np.arange(self.m))
            self.lengths = self._rest + self.L @ self.q + self._noise(NOISE, self.m)
            self.encoders = self.q + self._noise(NOISE, self.n)
            self.tensions = self.commands * (1.0 + self._noise(0.05, self.m))
            yield self

    def write(self, monitor: FaultMonitor) -> None:
        """Write the measurements to a monitor, with an inaccurate estimate of q."""
        q = self.q + 0.002
        monitor.write(
            lengths=self.lengths,
            encoders=self.encoders,
            tensions=self.tensions,
            commands=self.commands,
            q=q,
            path_lengths=self._rest + self.L @ q,
            jacobian=self.L,
        )

    def _noise(self, sd: float, count: int) -> FloatArray:
        noise: FloatArray = self._random.normal(0.0, sd, count)
        return noise
