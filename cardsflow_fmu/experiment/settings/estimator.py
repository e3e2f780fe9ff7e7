"""Settings of [estimator]: the state estimator between plant or hardware and controller."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from addin_sdfusion.robot import InputError, Pose, Robot
from addin_sdfusion.robot.model.muscle_laws import law_of
from cardsflow_fmu.cosim.signals.port import signal_names
from cardsflow_fmu.experiment.config.file import read_settings
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import (
    AS_WHOLE,
    Context,
    FromZero,
    Listed,
    Positive,
    Table,
    Text,
    Vector3,
    setting,
)
from cardsflow_fmu.utils.multiples import whole_steps
from sim_dart.estimation.sensors import MAX_DELAY, SensorSettings
from sim_dart.estimation.settings import MAX_FRAMES, MIN_FRAMES, EstimatorSettings, Imu

CALIBRATED = "calibrated"
"""Value of `offset` that selects the offsets found by `cardsflow calibrate`."""

CALIBRATION_FILE = "calibration.json"
"""Name of the file with these offsets, in the folder of the robot."""

_ORIGIN = (0.0, 0.0, 0.0)
_AS_ESTIMATOR = "(default: as [estimator])"


class ImuSettings(Table):
    """IMU (gyroscope and accelerometer) on a link."""

    link: Text = setting("link that carries the IMU")
    position: Vector3 = setting("position in the link frame, in m", _ORIGIN)
    rpy: Vector3 = setting("roll, pitch and yaw in the link frame, in rad", _ORIGIN)
    gyroscope_bias: Vector3 = setting("bias of the simulated gyroscope, in rad/s", _ORIGIN)
    accelerometer_bias: Vector3 = setting("bias of the simulated accelerometer, in m/s²", _ORIGIN)


class SensorsTable(Table):
    """Noise and resolution of the simulated sensors; see `sim_dart.estimation.sensors`."""

    length_noise: tuple[FromZero, ...] = named_setting(
        "muscle", f"standard deviation of the length measurement, in m {_AS_ESTIMATOR}", None
    )
    length_resolution: tuple[FromZero, ...] = named_setting(
        "muscle", "resolution of the length measurement, in m", 0.0
    )
    length_offset: tuple[float, ...] = named_setting(
        "muscle", "offset of the length measurement, in m", 0.0
    )
    tension_noise: tuple[FromZero, ...] = named_setting(
        "muscle", "standard deviation of the tension measurement, in N", 0.0
    )
    tension_resolution: tuple[FromZero, ...] = named_setting(
        "muscle", "resolution of the tension measurement, in N", 0.0
    )
    encoder_noise: tuple[FromZero, ...] = named_setting(
        "coordinate",
        f"standard deviation of the joint encoder, in rad or m {_AS_ESTIMATOR}",
        None,
    )
    encoder_resolution: tuple[FromZero, ...] = named_setting(
        "coordinate", "resolution of the joint encoder, in rad or m", 0.0
    )
    gyroscope_noise: FromZero = setting(
        f"standard deviation of the gyroscope, in rad/s {_AS_ESTIMATOR}", None
    )
    accelerometer_noise: FromZero = setting(
        f"standard deviation of the accelerometer, in m/s² {_AS_ESTIMATOR}", None
    )
    stuck: tuple[FromZero, ...] = named_setting(
        "muscle", "time at which the length measurement freezes, in s; 0 for never", 0.0
    )
    delay: FromZero = setting("delay of all measurements, in s; a multiple of run.step", 0.0)
    seed: Annotated[int, Field(ge=0, le=2**53), AS_WHOLE] = setting("seed of the noise", 0)

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """Return the table as plain data, without keys whose value comes from [estimator]."""
        return {key: value for key, value in super().data(leave_out).items() if value != []}


class EstimatorTable(Table):
    """State estimator: noise model of the sensors, and behaviour when the estimate is invalid."""

    use: bool = setting("use the estimator in runs", True)
    type: Literal["kalman", "horizon"] = setting(
        "kalman: extended Kalman filter; horizon: moving horizon with joint limits and robust loss",
        "kalman",
    )
    frames: Annotated[int, Field(ge=MIN_FRAMES, le=MAX_FRAMES), AS_WHOLE] = setting(
        "horizon: number of measurements that the horizon contains", 7
    )
    huber: FromZero = setting(
        "horizon: residual from which the loss of a measurement grows linearly, in standard "
        "deviations; 0: quadratic loss",
        2.0,
    )
    joint_limits: bool = setting("horizon: the estimate remains within the joint limits", True)
    feedback: bool = setting(
        "send the estimate to the controller; false: the controller uses the true state", True
    )
    ramp_down: FromZero = setting(
        "duration of the ramp to f_min after the estimate becomes invalid, in s", 0.5
    )
    ramp_in: FromZero = setting(
        "duration of the ramp from f_min after the estimate becomes valid again, in s", 0.2
    )
    length_noise: tuple[FromZero, ...] = named_setting(
        "muscle", "standard deviation of the length measurement, in m; 0: not measured", 1e-4
    )
    encoder_noise: tuple[FromZero, ...] = named_setting(
        "coordinate", "standard deviation of the joint encoder, in rad or m; 0: no encoder", 0.0
    )
    gyroscope_noise: FromZero = setting("standard deviation of the gyroscopes, in rad/s", 0.005)
    accelerometer_noise: FromZero = setting(
        "standard deviation of the accelerometers, in m/s²", 0.2
    )
    offset: tuple[float, ...] | None = named_setting(
        "muscle",
        f'known offset of the length measurement, in m; "{CALIBRATED}": the offsets of the '
        f"{CALIBRATION_FILE} in the folder of the robot",
        0.0,
        word=CALIBRATED,
    )
    min_tension: FromZero = setting("lengths of muscles with less tension are ignored, in N", 1.0)
    gate: Positive = setting(
        "measurements with a larger normalised innovation are ignored, in standard deviations", 5.0
    )
    acceleration_noise: tuple[FromZero, ...] = named_setting(
        "coordinate", "noise density of the joint accelerations, in rad/s²/√Hz or m/s²/√Hz", 0.01
    )
    load_drift: tuple[FromZero, ...] = named_setting(
        "coordinate",
        "noise density of the rate of unknown loads, in N·m/√s or N/√s; 0: no unknown loads",
        0.05,
    )
    gyroscope_drift: FromZero = setting(
        "noise density of the rate of the gyroscope biases, in rad/s/√s", 0.0
    )
    accelerometer_drift: FromZero = setting(
        "noise density of the rate of the accelerometer biases, in m/s²/√s", 0.0
    )
    offset_drift: tuple[FromZero, ...] = named_setting(
        "muscle",
        "noise density of the rate of the length offsets, in m/√s; 0 for all muscles, with "
        "start_offset_sd = 0: constant offsets",
        0.0,
    )
    exact_transition: bool = setting(
        "use the exact transition matrix; false: [I hI; 0 I], which is faster", True
    )
    find_start: bool = setting(
        "find the first pose from the first measurement; false: use the pose of [start]", False
    )
    start_candidates: Annotated[int, Field(ge=1, le=10000), AS_WHOLE] = setting(
        "number of initial guesses of the search for the first pose", 32
    )
    start_sd: tuple[FromZero, ...] = named_setting(
        "coordinate", "standard deviation of the pose of [start], in rad or m", 1e-3
    )
    start_speed_sd: tuple[FromZero, ...] = named_setting(
        "coordinate", "standard deviation of the initial velocities, in rad/s or m/s", 1e-2
    )
    start_load_sd: tuple[FromZero, ...] = named_setting(
        "coordinate", "standard deviation of the initial unknown loads, in N·m or N", 1.0
    )
    start_offset_sd: tuple[FromZero, ...] = named_setting(
        "muscle", "standard deviation of the initial length offsets, in m", 0.0
    )
    gyroscope_bias_sd: FromZero = setting(
        "standard deviation of the initial gyroscope biases, in rad/s", 0.01
    )
    accelerometer_bias_sd: FromZero = setting(
        "standard deviation of the initial accelerometer biases, in m/s²", 0.1
    )
    max_sd: tuple[Positive, ...] = named_setting(
        "coordinate", "maximum standard deviation of a valid estimate, in rad or m", 0.05
    )
    max_innovation: Positive = setting(
        "maximum mean square of the normalised innovations of a valid estimate", 4.0
    )
    innovation_time: Positive = setting(
        "averaging time of the innovations, in s; also the longest time without a measurement", 0.05
    )
    imus: Annotated[tuple[ImuSettings, ...], Listed] = setting(
        "IMUs: tables [[estimator.imus]]", ()
    )
    sensors: SensorsTable = setting("noise and resolution of the simulated sensors", {})

    @model_validator(mode="after")
    def _check_type(self) -> Self:
        if self.type == "horizon":
            return self
        for key in ("frames", "huber", "joint_limits"):
            if getattr(self, key) != type(self).model_fields[key].default:
                raise SettingError('requires estimator.type = "horizon"', key=key)
        return self

    @property
    def inertial_units(self) -> tuple[Imu, ...]:
        """The IMUs with their poses on the links."""
        return tuple(Imu(imu.link, Pose(imu.position, imu.rpy)) for imu in self.imus)

    @property
    def links(self) -> tuple[str, ...]:
        """The link of each IMU."""
        return tuple(imu.link for imu in self.imus)

    @property
    def encoder_indices(self) -> list[int]:
        """Indices of the coordinates with an encoder."""
        return [j for j, noise in enumerate(self.encoder_noise) if noise > 0]

    @property
    def estimator_settings(self) -> EstimatorSettings:
        """Noise and limits as settings of a `PoseEstimator`."""
        values = {
            name: getattr(self, name)
            for name in EstimatorSettings.__dataclass_fields__
            if name != "compliance"
        }
        return EstimatorSettings(**values)

    def delay(self, step: float) -> int:
        """Return the delay of the simulated sensors as a number of measurements.

        Args:
            step: Time between two measurements, in [s].
        """
        time = self.sensors.delay
        return whole_steps(time, step, "run.step") if time else 0

    def sensor_settings(self, robot: Robot, step: float) -> SensorSettings:
        """Return noise, resolution, offset and faults of every sensor channel."""
        sensors, n, m = self.sensors, len(robot.coordinates), len(robot.muscles)
        lengths, encoders = sensors.length_noise or self.length_noise, sensors.encoder_noise
        turning, force = self.gyroscope_noise, self.accelerometer_noise
        if sensors.gyroscope_noise is not None:
            turning = sensors.gyroscope_noise
        if sensors.accelerometer_noise is not None:
            force = sensors.accelerometer_noise
        none, biases = np.zeros(n), [u.gyroscope_bias for u in self.imus]
        biases += [u.accelerometer_bias for u in self.imus]
        units = 3 * len(self.imus)
        row = np.concatenate
        noise = (
            *(lengths, sensors.tension_noise, none, encoders or self.encoder_noise),
            *(np.full(units, turning), np.full(units, force)),
        )
        stuck = np.full(2 * m + 2 * n + 2 * units, np.inf)
        stuck[:m] = [time or np.inf for time in sensors.stuck]
        return SensorSettings(
            noise=row(noise),
            resolution=row(
                (
                    *(sensors.length_resolution, sensors.tension_resolution),
                    *(none, sensors.encoder_resolution, np.zeros(2 * units)),
                )
            ),
            offset=row((sensors.length_offset, np.zeros(m), none, none, np.ravel(biases))),
            stuck=stuck,
            delay=self.delay(step),
            seed=sensors.seed,
        )


def read_estimator(
    data: object, context: Context, robot: Robot, folder: Path | None, step: float
) -> EstimatorTable:
    """Read the table [estimator]."""
    if isinstance(data, Mapping) and data.get("offset") == CALIBRATED:
        data = {**data, "offset": _calibrated_offsets(folder, context)}
    settings = EstimatorTable.read(data, context, "estimator")
    for loop in robot.loops:
        problem = f"joint {loop.name!r} closes a loop, which the estimator does not support"
        raise context.error("estimator", problem)
    for muscle in robot.muscles:
        if law_of(muscle.model).sags:
            problem = f"muscle {muscle.name!r} sags, but the estimator requires straight paths"
            raise context.error("estimator", problem)
    links = [link.name for link in robot.links]
    for k, unit in enumerate(settings.imus):
        context.require(f"estimator.imus[{k}].link", "link", unit.link, links)
    with context.at("estimator.imus"):
        signal_names("gyroscope", settings.links)
    with context.at("estimator.sensors.delay"):
        if settings.sensors.delay:
            whole_steps(settings.sensors.delay, step, "run.step", most=MAX_DELAY)
    return settings


def _calibrated_offsets(folder: Path | None, context: Context) -> dict[str, Any]:
    """Return the offsets found by `cardsflow calibrate`, by muscle."""
    key = "estimator.offset"
    if folder is None:
        raise context.error(key, f"several robots have no {CALIBRATION_FILE}; set numbers")
    file = folder / CALIBRATION_FILE
    if not file.is_file():
        problem = f"{file} does not exist; create it with `cardsflow calibrate`"
        raise context.error(key, problem)
    offsets = read_settings(file).get("offsets")
    if not isinstance(offsets, dict) or not offsets:
        problem = "has no offsets; run `cardsflow calibrate --parameters 'muscles.*.offset'`"
        raise InputError(problem, file=file)
    return offsets
