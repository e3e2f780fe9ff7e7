"""Errors of simulated sensors: noise, resolution, offsets and delay; see csrc/sensors/sensors.h."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

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
