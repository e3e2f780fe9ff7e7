"""Settings of an estimator: sensor noise, model errors and limits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Pose

TYPES = ("kalman", "horizon")
"""Types of estimators."""

MIN_FRAMES, MAX_FRAMES = 2, 1000
"""Limits of the number of measurements in a horizon, as in horizon_handle.c."""


@dataclass(frozen=True)
class Imu:
    """IMU (inertial measurement unit) on a link, with gyroscope and accelerometer.

    Attributes:
        link: Name of the link.
        pose: Pose of the IMU in the link frame.
    """

    link: str
    pose: Pose = field(default_factory=Pose)


@dataclass(frozen=True)
class EstimatorSettings:
    """Standard deviations and limits of an estimator.

    A number applies to all joints, muscles or IMUs, an array contains a value for each of them. A
    quantity with noise 0 or infinity is not measured.

    Attributes:
        type: "kalman" for the extended Kalman filter, or "horizon" for a moving horizon, which also
            uses the following three settings.
        frames: Number of measurements in the horizon.
        huber: Residual from which the loss of a measurement grows linearly, in standard deviations;
            0 for a quadratic loss. With 2, the efficiency for Gaussian noise is 99 % (Huber 1964).
        joint_limits: Whether the estimate remains within the joint limits.
        length_noise: Standard deviation of measured muscle lengths, in [m].
        encoder_noise: Standard deviation of joint encoders, in [rad] or [m].
        gyroscope_noise: Standard deviation of gyroscopes, in [rad/s].
        accelerometer_noise: Standard deviation of accelerometers, in [m/s²].
        offset: Length offset b of l_m = l - c f + b, in [m].
        compliance: Compliance c, in [m/N], or None for the compliance of the robot's cables.
        min_tension: Tension below which a muscle length is ignored, in [N].
        gate: Largest innovation of a measurement that is used, in standard deviations.
        acceleration_noise: Density of white noise of accelerations, in [rad/s²/√Hz].
        load_drift: Density of white noise of the rate of unknown loads, in [N·m/√s]; 0 for an exact
            model.
        gyroscope_drift, accelerometer_drift: Density of white noise of the rates of biases, in
            [rad/s/√s] and [m/s²/√s].
        offset_drift: Density of white noise of the rates of length offsets, in [m/√s].
        exact_transition: Use the exact derivative of the step as transition matrix; otherwise
            [I hI; 0 I].
        find_start: Search the start pose from the first measurements.
        start_candidates: Number of start poses of the search.
        start_sd: Standard deviation of a known start pose, in [rad] or [m].
        start_speed_sd: Standard deviation of the start velocities, in [rad/s] or [m/s].
        start_load_sd: Standard deviation of the unknown loads at the start, in [N·m] or [N].
        start_offset_sd: Standard deviation of the length offsets at the start, in [m]. The offsets
            are constant if this and `offset_drift` are 0 for all muscles.
        gyroscope_bias_sd, accelerometer_bias_sd: Standard deviations of biases at the start, in
            [rad/s] and [m/s²].
        max_sd: Largest standard deviation of a coordinate for a valid estimate, in [rad] or [m].
        max_innovation: Largest mean square of normalised innovations for a valid estimate.
        innovation_time: Averaging time of the innovations, in [s]. An estimate without any
            measurement for this time is not valid.
    """

    type: Literal["kalman", "horizon"] = "kalman"
    frames: int = 7
    huber: float = 2.0
    joint_limits: bool = True
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
    offset_drift: ArrayLike = 0.0
    exact_transition: bool = True
    find_start: bool = False
    start_candidates: int = 32
    start_sd: ArrayLike = 1e-3
    start_speed_sd: ArrayLike = 1e-2
    start_load_sd: ArrayLike = 1.0
    start_offset_sd: ArrayLike = 0.0
    gyroscope_bias_sd: float = 0.01
    accelerometer_bias_sd: float = 0.1
    max_sd: ArrayLike = 0.05
    max_innovation: float = 4.0
    innovation_time: float = 0.05

    def __post_init__(self) -> None:
        """Check that all settings are numbers in their ranges.

        Raises:
            InputError: A setting is negative or not a number. The message contains its name.
        """
        if self.type not in TYPES:
            raise InputError(f"type must be one of {', '.join(TYPES)}, not {self.type!r}")
        if not MIN_FRAMES <= self.frames <= MAX_FRAMES:
            raise InputError(
                f"frames must be from {MIN_FRAMES} to {MAX_FRAMES}, not {self.frames!r}"
            )
        for one in fields(self):
            value = getattr(self, one.name)
            if value is None or one.name == "type":
                continue
            numbers = np.asarray(value, dtype=float)
            signed = one.name == "offset"
            if np.isnan(numbers).any() or (not signed and (numbers < 0).any()):
                raise InputError(f"{one.name} must not be negative or NaN: {value!r}")
        for name in ("gate", "innovation_time", "start_candidates"):
            if not 0 < getattr(self, name) < math.inf:
                raise InputError(f"{name} must be positive and finite, not {getattr(self, name)!r}")

    @property
    def estimates_offsets(self) -> bool:
        """Whether the length offsets are part of the state."""
        return bool(np.any(self.offset_drift) or np.any(self.start_offset_sd))


def arrays(settings: EstimatorSettings) -> Mapping[str, ArrayLike]:
    """Return the settings by the names of the C library's arrays."""
    copied = (
        "length_noise encoder_noise gyroscope_noise accelerometer_noise offset gate "
        "acceleration_noise load_drift innovation_time"
    )
    if settings.estimates_offsets:
        copied += " offset_drift start_offset_sd"
    return {name: getattr(settings, name) for name in copied.split()} | {
        "bias_drift": (settings.gyroscope_drift, settings.accelerometer_drift),
        "slack": settings.min_tension,
        "search": settings.find_start,
        "starts": settings.start_candidates,
        "largest_sd": settings.max_sd,
        "largest_innovation": settings.max_innovation,
    }
