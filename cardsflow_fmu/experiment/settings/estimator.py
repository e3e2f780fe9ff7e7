"""[estimator]: the state from the muscles, between plant or hardware and controller."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from addin_sdfusion.robot import InputError, Pose, Robot
from addin_sdfusion.robot.model.tension_laws import law_of
from cardsflow_fmu.cosim.signals.port import signal_names
from cardsflow_fmu.experiment.config.file import read_settings
from cardsflow_fmu.experiment.config.names import each
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
from sim_dart.estimation.sensors import MOST_DELAY, SensorSettings
from sim_dart.estimation.settings import EstimatorSettings, InertialUnit

CALIBRATED = "calibrated"
"""Word for offsets that the calibration of the robot has found."""

CALIBRATION_FILE = "calibration.json"
"""Where it has written them, beside the robot."""

_ORIGIN = (0.0, 0.0, 0.0)
_AS_BELIEVED = "as the estimator believes when left out"


class ImuSettings(Table):
    """A gyroscope and an accelerometer on a link."""

    link: Text = setting("the link that it is on")
    position: Vector3 = setting("in the link, in m", _ORIGIN)
    rpy: Vector3 = setting("roll, pitch and yaw in the link, in rad", _ORIGIN)
    gyroscope_bias: Vector3 = setting("of the simulated one, in rad/s", _ORIGIN)
    accelerometer_bias: Vector3 = setting("of the simulated one, in m/s²", _ORIGIN)


class SensorsTable(Table):
    """How good simulated sensors are; see `sim_dart.estimation.sensors`."""

    length_noise: tuple[FromZero, ...] = each(
        "muscle", f"standard deviation of a length, in m; {_AS_BELIEVED}", None
    )
    length_resolution: tuple[FromZero, ...] = each("muscle", "of a length, in m", 0.0)
    length_offset: tuple[float, ...] = each("muscle", "of a length, in m", 0.0)
    tension_noise: tuple[FromZero, ...] = each("muscle", "standard deviation, in N", 0.0)
    tension_resolution: tuple[FromZero, ...] = each("muscle", "of a tension, in N", 0.0)
    encoder_noise: tuple[FromZero, ...] = each(
        "coordinate", f"standard deviation, in rad or m; {_AS_BELIEVED}", None
    )
    encoder_resolution: tuple[FromZero, ...] = each("coordinate", "in rad or m", 0.0)
    gyroscope_noise: FromZero = setting(f"in rad/s; {_AS_BELIEVED}", None)
    accelerometer_noise: FromZero = setting(f"in m/s²; {_AS_BELIEVED}", None)
    stuck: tuple[FromZero, ...] = each("muscle", "when its length sticks, in s; 0 for never", 0.0)
    delay: FromZero = setting("of all readings, in s: a whole multiple of run.step", 0.0)
    seed: Annotated[int, Field(ge=0, le=2**53), AS_WHOLE] = setting("of the noise", 0)

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """As of any table; without what is as the estimator believes."""
        return {key: value for key, value in super().data(leave_out).items() if value != []}


class EstimatorTable(Table):
    """The estimator, what it believes of its sensors, and what happens when it is lost."""

    use: bool = setting("whether runs have it", True)
    feedback: bool = setting("whether the controller gets the estimate; else it only watches", True)
    ramp_down: FromZero = setting("of commands to f_min when the estimate is lost, in s", 0.5)
    ramp_in: FromZero = setting("from f_min when it is back, in s", 0.2)
    length_noise: tuple[FromZero, ...] = each(
        "muscle", "standard deviation of a length, in m; 0 where it is not measured", 1e-4
    )
    encoder_noise: tuple[FromZero, ...] = each(
        "coordinate", "standard deviation, in rad or m; 0 where there is no encoder", 0.0
    )
    gyroscope_noise: FromZero = setting("standard deviation, in rad/s", 0.005)
    accelerometer_noise: FromZero = setting("standard deviation, in m/s²", 0.2)
    offset: tuple[float, ...] | None = each(
        "muscle",
        f"known offset of a length, in m; those that {CALIBRATION_FILE} beside the robot has",
        0.0,
        word=CALIBRATED,
    )
    min_tension: FromZero = setting("muscles with less tension are left out, in N", 1.0)
    gate: Positive = setting("readings that are farther off are left out, in deviations", 5.0)
    acceleration_noise: tuple[FromZero, ...] = each(
        "coordinate", "density of noise on accelerations, in rad/s²/√Hz or m/s²/√Hz", 0.01
    )
    load_drift: tuple[FromZero, ...] = each(
        "coordinate",
        "density of the unknown loads' rate, in N·m/√s or N/√s; 0: known exactly",
        0.05,
    )
    gyroscope_drift: FromZero = setting("density of the biases' rate, in rad/s/√s", 0.0)
    accelerometer_drift: FromZero = setting("density of the biases' rate, in m/s²/√s", 0.0)
    exact_transition: bool = setting(
        "exact transition matrix; false for [I hI; 0 I], which is faster", True
    )
    find_start: bool = setting(
        "whether the first pose is searched; else it is that of the start", False
    )
    start_candidates: Annotated[int, Field(ge=1, le=10000), AS_WHOLE] = setting(
        "poses that the search begins from", 32
    )
    start_sd: tuple[FromZero, ...] = each(
        "coordinate", "standard deviation of a start that is known, in rad or m", 1e-3
    )
    start_speed_sd: tuple[FromZero, ...] = each("coordinate", "in rad/s or m/s", 1e-2)
    start_load_sd: tuple[FromZero, ...] = each("coordinate", "of unknown loads, in N·m or N", 1.0)
    gyroscope_bias_sd: FromZero = setting("of a bias, in rad/s", 0.01)
    accelerometer_bias_sd: FromZero = setting("of a bias, in m/s²", 0.1)
    max_sd: tuple[Positive, ...] = each(
        "coordinate", "a valid estimate's largest standard deviation, in rad or m", 0.05
    )
    max_innovation: Positive = setting("a valid estimate's largest mean square", 4.0)
    innovation_time: Positive = setting(
        "over which that is averaged, in s; without any reading for so long it is not valid", 0.05
    )
    imus: Annotated[tuple[ImuSettings, ...], Listed] = setting(
        "inertial units: [[estimator.imus]]", ()
    )
    sensors: SensorsTable = setting("how good simulated sensors are", {})

    @property
    def inertial_units(self) -> tuple[InertialUnit, ...]:
        """The units, where they are."""
        return tuple(InertialUnit(unit.link, Pose(unit.position, unit.rpy)) for unit in self.imus)

    @property
    def links(self) -> tuple[str, ...]:
        """The link of each unit."""
        return tuple(unit.link for unit in self.imus)

    @property
    def encoded(self) -> list[int]:
        """Indices of the coordinates with an encoder."""
        return [j for j, noise in enumerate(self.encoder_noise) if noise > 0]

    @property
    def believed(self) -> EstimatorSettings:
        """Noises and limits as the estimator takes them."""
        own = {
            name: getattr(self, name)
            for name in EstimatorSettings.__dataclass_fields__
            if name != "compliance"
        }
        return EstimatorSettings(**own)

    def delay(self, step: float) -> int:
        """How many readings simulated sensors are late by.

        Args:
            step: Time between two readings, in [s].
        """
        time = self.sensors.delay
        return whole_steps(time, step, "run.step") if time else 0

    def sensor_settings(self, robot: Robot, step: float) -> SensorSettings:
        """How good simulated sensors are, of every channel.

        Args:
            robot: The robot.
            step: Time between two readings, in [s].
        """
        own, n, m = self.sensors, len(robot.coordinates), len(robot.muscles)
        lengths, encoders = own.length_noise or self.length_noise, own.encoder_noise
        turning = self.gyroscope_noise if own.gyroscope_noise is None else own.gyroscope_noise
        force = self.accelerometer_noise
        if own.accelerometer_noise is not None:
            force = own.accelerometer_noise
        none, biases = np.zeros(n), [u.gyroscope_bias for u in self.imus]
        biases += [u.accelerometer_bias for u in self.imus]
        units = 3 * len(self.imus)
        row = np.concatenate
        noise = (
            *(lengths, own.tension_noise, none, encoders or self.encoder_noise),
            *(np.full(units, turning), np.full(units, force)),
        )
        stuck = np.full(2 * m + 2 * n + 2 * units, np.inf)
        stuck[:m] = [time or np.inf for time in own.stuck]
        return SensorSettings(
            noise=row(noise),
            resolution=row(
                (
                    *(own.length_resolution, own.tension_resolution),
                    *(none, own.encoder_resolution, np.zeros(2 * units)),
                )
            ),
            offset=row((own.length_offset, np.zeros(m), none, none, np.ravel(biases))),
            stuck=stuck,
            delay=self.delay(step),
            seed=own.seed,
        )


def read_estimator(
    data: object, context: Context, robot: Robot, folder: Path | None, step: float
) -> EstimatorTable:
    """What an experiment says of its estimator.

    Args:
        data: The table.
        context: What it is read with.
        robot: The robot.
        folder: That of its files; None where it is several.
        step: run.step, in [s].
    """
    if isinstance(data, Mapping) and data.get("offset") == CALIBRATED:
        data = {**data, "offset": _calibrated_offsets(folder, context)}
    settings = EstimatorTable.read(data, context, "estimator")
    for loop in robot.loops:
        what = f"joint {loop.name!r} closes a loop, which the estimator does not know of"
        raise context.error("estimator", what)
    for muscle in robot.muscles:
        if law_of(muscle.model).sags:
            what = f"muscle {muscle.name!r} sags, and lengths tell the estimator of straight paths"
            raise context.error("estimator", what)
    links = [link.name for link in robot.links]
    for k, unit in enumerate(settings.imus):
        context.require(f"estimator.imus[{k}].link", "link", unit.link, links)
    with context.at("estimator.imus"):
        signal_names("gyroscope", settings.links)
    with context.at("estimator.sensors.delay"):
        if settings.sensors.delay:
            whole_steps(settings.sensors.delay, step, "run.step", most=MOST_DELAY)
    return settings


def _calibrated_offsets(folder: Path | None, context: Context) -> dict[str, Any]:
    """The offsets that `cardsflow calibrate` has found, by muscle.

    Raises:
        InputError: There are none.
    """
    key = "estimator.offset"
    if folder is None:
        raise context.error(key, f"several robots have no {CALIBRATION_FILE}; give numbers")
    file = folder / CALIBRATION_FILE
    if not file.is_file():
        what = f"there is no {file}, which `cardsflow calibrate` writes beside the robot"
        raise context.error(key, what)
    offsets = read_settings(file).get("offsets")
    if not isinstance(offsets, dict) or not offsets:
        what = "has no offsets: `cardsflow calibrate` finds them where muscles.*.offset are free"
        raise InputError(what, file=file)
    return offsets
