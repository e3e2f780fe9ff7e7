"""The sensors of an emulated robot: noise, offsets, encoder counts, finite differences."""

from __future__ import annotations

import math

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.settings.hardware import SensorSettings
from cardsflow_fmu.utils.arrays import FloatArray


class Sensors:
    """Sensors of n joints and m muscles, read together.

    Raises:
        InputError: There is not an offset for each muscle.

    Attributes:
        q: Positions as read, shape (n,), in [rad] or [m].
        qd: Velocities, shape (n,), in [rad/s] or [m/s].
        lengths: Path lengths and offsets, shape (m,), in [m].
    """

    def __init__(self, settings: SensorSettings, joints: int, muscles: int) -> None:
        self._settings = settings
        self._offset = np.array(settings.length_offset or (0.0,) * muscles)
        if len(self._offset) != muscles:
            raise InputError(f"length_offset must be {muscles} numbers, not {len(self._offset)}")
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
        if self._settings.differentiate_positions:
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
        if self._settings.differentiate_positions:
            self.qd = (self.q - before) / dt

    def _read(self, q: FloatArray, qd: FloatArray, lengths: FloatArray) -> None:
        settings = self._settings
        self.q = _quantised(self._noisy(q), settings.joint_counts)
        self.qd = self._noisy(qd)
        self.lengths = _quantised(self._noisy(lengths) + self._offset, settings.length_counts)

    def _noisy(self, values: FloatArray) -> FloatArray:
        """Return values with noise; a copy in any case."""
        if self._settings.noise == 0:
            return values.copy()
        noisy: FloatArray = values + self._random.normal(0.0, self._settings.noise, len(values))
        return noisy


def _quantised(values: FloatArray, counts: float) -> FloatArray:
    """Return values to the nearest count; as they are where counts are finer than floats."""
    if math.isinf(counts):
        return values
    with np.errstate(over="ignore"):
        counted = values * counts
    quantised: FloatArray = np.where(np.isfinite(counted), np.round(counted) / counts, values)
    return quantised
