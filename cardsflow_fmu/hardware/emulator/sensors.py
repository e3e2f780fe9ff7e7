"""Sensor models of an emulated robot: noise, offsets, encoder counts, finite differences."""

from __future__ import annotations

import math

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.settings.hardware import SensorSettings
from cardsflow_fmu.utils.arrays import FloatArray


class Sensors:
    """Sensors of n coordinates and m muscles, which are sampled together.

    Args:
        settings: Errors of the sensors.
        joints: Number of coordinates n.
        muscles: Number of muscles m.

    Raises:
        InputError: The number of length offsets differs from the number of muscles.

    Attributes:
        q: Measured positions, shape (n,), in [rad] or [m].
        qd: Measured velocities, shape (n,), in [rad/s] or [m/s].
        lengths: Measured muscle lengths, which include the offsets, shape (m,), in [m].
        tensions: Measured tensions, shape (m,), in [N].
    """

    def __init__(self, settings: SensorSettings, joints: int, muscles: int) -> None:
        self._settings = settings
        self._offset = np.array(settings.length_offset or (0.0,) * muscles)
        if len(self._offset) != muscles:
            raise InputError(f"length_offset must be {muscles} numbers, not {len(self._offset)}")
        self._random = np.random.default_rng(settings.seed)
        self.q, self.qd = np.zeros(joints), np.zeros(joints)
        self.lengths, self.tensions = np.zeros(muscles), np.zeros(muscles)

    def reset(
        self, q: FloatArray, qd: FloatArray, lengths: FloatArray, tensions: FloatArray
    ) -> None:
        """Restart the noise from its seed, and take the first measurement of the true values.

        Velocities from finite differences are zero.
        """
        self._random = np.random.default_rng(self._settings.seed)
        self._read(q, qd, lengths, tensions)
        if self._settings.differentiate_positions:
            self.qd = np.zeros(len(q))

    def read(
        self, q: FloatArray, qd: FloatArray, lengths: FloatArray, tensions: FloatArray, dt: float
    ) -> None:
        """Measure the true values, dt [s] after the previous measurement."""
        before = self.q
        self._read(q, qd, lengths, tensions)
        if self._settings.differentiate_positions:
            self.qd = (self.q - before) / dt

    def _read(
        self, q: FloatArray, qd: FloatArray, lengths: FloatArray, tensions: FloatArray
    ) -> None:
        settings = self._settings
        self.q = _quantise(self._add_noise(q), settings.joint_counts)
        self.qd = self._add_noise(qd)
        self.lengths = _quantise(self._add_noise(lengths) + self._offset, settings.length_counts)
        self.tensions = tensions.copy()
        if settings.tension_noise:
            factors = self._random.normal(1.0, settings.tension_noise, len(tensions))
            self.tensions *= factors

    def _add_noise(self, values: FloatArray) -> FloatArray:
        """Return a copy of the values with added noise."""
        if self._settings.noise == 0:
            return values.copy()
        noisy: FloatArray = values + self._random.normal(0.0, self._settings.noise, len(values))
        return noisy


def _quantise(values: FloatArray, counts: float) -> FloatArray:
    """Return the values rounded to whole counts.

    Values whose number of counts exceeds the floating-point range are returned unchanged.
    """
    if math.isinf(counts):
        return values
    with np.errstate(over="ignore"):
        counted = values * counts
    quantised: FloatArray = np.where(np.isfinite(counted), np.round(counted) / counts, values)
    return quantised
