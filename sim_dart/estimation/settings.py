"""Settings of an estimator: its sensors, and how well the robot's model is known."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Pose


@dataclass(frozen=True)
class InertialUnit:
    """A gyroscope and an accelerometer on a link.

    Attributes:
        link: The link's name.
        pose: Of the unit in the link.
    """

    link: str
    pose: Pose = field(default_factory=Pose)


@dataclass(frozen=True)
class EstimatorSettings:
    """Standard deviations and limits of an estimator.

    A number counts for all joints, muscles or units; an array for each of them. What has the noise
    0 or infinity is not measured.

    Attributes:
        length_noise: Of a reading of a muscle's length, in [m].
        encoder_noise: Of a joint's encoder, in [rad] or [m].
        gyroscope_noise: In [rad/s].
        accelerometer_noise: In [m/s²].
        offset: b of l_m = l - c f + b, in [m].
        compliance: c, in [m/N]; None for what the robot's elastic cables have.
        min_tension: A muscle with less tension is left out, in [N].
        gate: A reading farther from what is expected, in standard deviations, is left out.
        acceleration_noise: Density of white noise on accelerations, in [rad/s²/√Hz].
        load_drift: Density of white noise on the unknown loads' rate, in [N·m/√s]; 0 if the
            model is exact.
        gyroscope_drift, accelerometer_drift: The same of biases, in [rad/s/√s] and [m/s²/√s].
        exact_transition: Use the exact derivative of the step as transition matrix; otherwise
            [I hI; 0 I].
        find_start: Whether the first pose is searched, from the first measurements alone.
        start_candidates: Poses that the search begins from.
        start_sd: Of the pose at the start if it is known, in [rad] or [m].
        start_speed_sd: Of the velocities, in [rad/s] or [m/s].
        start_load_sd: Of the unknown loads, in [N·m] or [N].
        gyroscope_bias_sd, accelerometer_bias_sd: In [rad/s] and [m/s²].
        max_sd: Of a coordinate, beyond which an estimate is not valid, in [rad] or [m].
        max_innovation: Mean square of innovations over their variance, likewise.
        innovation_time: Over which that is averaged, in [s]; an estimate without any reading for
            so long is not valid.
    """

    length_noise: ArrayLike = 1e-4
    encoder_noise: ArrayLike = 0.0
    gyroscope_noise: ArrayLike = 0.005
    accelerometer_noise: ArrayLike = 0.2
    offset: ArrayLike = 0.0
    compliance: ArrayLike | None = None
    min_tension: float = 1.0
    gate: float = 5.0
    acceleration_noise: ArrayLike = 0.01
    load_drift: ArrayLike = 0.05
    gyroscope_drift: float = 0.0
    accelerometer_drift: float = 0.0
    exact_transition: bool = True
    find_start: bool = False
    start_candidates: int = 32
    start_sd: ArrayLike = 1e-3
    start_speed_sd: ArrayLike = 1e-2
    start_load_sd: ArrayLike = 1.0
    gyroscope_bias_sd: float = 0.01
    accelerometer_bias_sd: float = 0.1
    max_sd: ArrayLike = 0.05
    max_innovation: float = 4.0
    innovation_time: float = 0.05

    def __post_init__(self) -> None:
        """Reject what is not a number, or negative.

        Raises:
            InputError: With the setting's name.
        """
        for one in fields(self):
            value = getattr(self, one.name)
            if value is None:
                continue
            numbers = np.asarray(value, dtype=float)
            signed = one.name == "offset"
            if np.isnan(numbers).any() or (not signed and (numbers < 0).any()):
                raise InputError(f"{one.name} must not be negative or NaN: {value!r}")
        for name in ("gate", "innovation_time", "start_candidates"):
            if not 0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} must be positive and finite, not {getattr(self, name)!r}")


def arrays(settings: EstimatorSettings) -> Mapping[str, ArrayLike]:
    """Return the settings by the names of the C library's arrays."""
    copied = (
        "length_noise encoder_noise gyroscope_noise accelerometer_noise offset gate "
        "acceleration_noise load_drift innovation_time"
    )
    return {name: getattr(settings, name) for name in copied.split()} | {
        "bias_drift": (settings.gyroscope_drift, settings.accelerometer_drift),
        "slack": settings.min_tension,
        "search": settings.find_start,
        "starts": settings.start_candidates,
        "largest_sd": settings.max_sd,
        "largest_innovation": settings.max_innovation,
    }
