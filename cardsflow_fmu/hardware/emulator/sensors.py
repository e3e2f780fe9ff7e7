"""The sensors of an emulated robot: noise, encoder counts, finite differences."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class SensorSettings:
    """How good the sensors are; perfect without arguments.

    Attributes:
        joint_counts: Counts of a joint's encoder, per [rad] or [m]; infinite for exact values.
        length_counts: Counts of a muscle's encoder, per [m].
        noise: Standard deviation of a reading before it is counted: in [rad] or [m] of positions
            and lengths, and of velocities that are measured, in [rad/s] or [m/s].
        differences: Whether velocities are differences of readings instead of being measured.
        seed: Seed of the noise.

    Raises:
        InputError: A value is out of range.
    """

    joint_counts: float = math.inf
    length_counts: float = math.inf
    noise: float = 0.0
    differences: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("joint_counts", "length_counts"):
            if not getattr(self, name) > 0:
                raise InputError(f"{name} must be above 0, not {getattr(self, name)!r}")
        if not 0 <= self.noise < math.inf:
            raise InputError(f"the noise must be 0 or more, not {self.noise!r}")
        if self.seed < 0:
            raise InputError(f"the seed must be 0 or more, not {self.seed!r}")


class Sensors:
    """Sensors of n joints and m muscles, read together.

    Args:
        settings: Their errors.
        joints: n.
        muscles: m.

    Attributes:
        q: Positions as read, shape (n,), in [rad] or [m].
        qd: Velocities, shape (n,), in [rad/s] or [m/s].
        lengths: Path lengths, shape (m,), in [m].
    """

    def __init__(self, settings: SensorSettings, joints: int, muscles: int) -> None:
        self._settings = settings
        self._random = np.random.default_rng(settings.seed)
        self.q, self.qd = np.zeros(joints), np.zeros(joints)
        self.lengths = np.zeros(muscles)

    def reset(self, q: FloatArray, qd: FloatArray, lengths: FloatArray) -> None:
        """Take the first reading, with the noise from its seed; differences are zero.

        Args:
            q: True positions, shape (n,).
            qd: True velocities, shape (n,).
            lengths: True lengths, shape (m,).
        """
        self._random = np.random.default_rng(self._settings.seed)
        self._read(q, qd, lengths)
        if self._settings.differences:
            self.qd = np.zeros(len(q))

    def read(self, q: FloatArray, qd: FloatArray, lengths: FloatArray, dt: float) -> None:
        """Take a reading, dt after the one before.

        Args:
            q: True positions, shape (n,).
            qd: True velocities, shape (n,).
            lengths: True lengths, shape (m,).
            dt: In [s].
        """
        before = self.q
        self._read(q, qd, lengths)
        if self._settings.differences:
            self.qd = (self.q - before) / dt

    def _read(self, q: FloatArray, qd: FloatArray, lengths: FloatArray) -> None:
        settings = self._settings
        self.q = _quantised(self._noisy(q), settings.joint_counts)
        self.qd = self._noisy(qd)
        self.lengths = _quantised(self._noisy(lengths), settings.length_counts)

    def _noisy(self, values: FloatArray) -> FloatArray:
        """Values with noise; a copy in any case."""
        if self._settings.noise == 0:
            return values.copy()
        noisy: FloatArray = values + self._random.normal(0.0, self._settings.noise, len(values))
        return noisy


def _quantised(values: FloatArray, counts: float) -> FloatArray:
    """Values to the nearest count."""
    if math.isinf(counts):
        return values
    quantised: FloatArray = np.round(values * counts) / counts
    return quantised
