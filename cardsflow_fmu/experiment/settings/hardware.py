"""Settings of [hardware]: the link to a robot, its timing, and safety limits."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from addin_sdfusion.robot import Robot
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.multiples import require_multiple
from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import (
    AS_WHOLE,
    Context,
    File,
    Fraction,
    FromZero,
    Listed,
    Pair,
    Positive,
    Table,
    Text,
    setting,
)

CommandKind = Literal["force", "length", "velocity"]
Mode = Literal["realtime", "lockstep"]

MAX_RAMP_DOWN = 3.0
"""Maximum duration, in [s]. FMI importers kill worker processes that do not end within 5 s."""

_WATCHDOG, _WATCHDOG_STEPS = 0.02, 5
_CHANCE = "probability that a frame is {}, from 0 to 1"
_Seed = Annotated[int, Field(ge=0), AS_WHOLE]


class MotorSettings(Table):
    """Motor commands; see `motors.MotorMap`."""

    command: CommandKind = setting("quantity that the motors receive as command", "force")
    stiffness: tuple[Positive, ...] = named_setting("muscle", "spring stiffness, in N/m", None)
    damping: tuple[FromZero, ...] = named_setting("muscle", "spring damping, in N·s/m", 0.0)
    spindle_radius: tuple[Positive, ...] = named_setting(
        "muscle", "spindle radius of motors that are commanded with angles, in m", None
    )
    encoder_scale: tuple[Positive, ...] = named_setting(
        "muscle", "encoder counts per rad with a spindle_radius, otherwise per m", None
    )
    offset: tuple[float, ...] | None = named_setting(
        "muscle",
        'set point at which the encoders count 0, in m; "start": the set point of the start pose',
        0.0,
        word="start",
    )

    @model_validator(mode="after")
    def _check_springs(self) -> Self:
        if self.command == "force":
            self.require_only(["command"])
        elif not self.stiffness:
            raise SettingError("missing", key="stiffness")
        return self

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """Return the table as plain data; only `command` for force commands."""
        if self.command == "force":
            return {"command": "force"}
        return {"offset": "start", **super().data(leave_out)}


class Faults(Table):
    """Transmission faults of `emulated:`, in each direction (default: none)."""

    loss: Fraction = setting(_CHANCE.format("lost"), 0.0)
    delay: FromZero = setting("delay of every frame, in s", 0.0)
    jitter: FromZero = setting("maximum additional delay, in s; uniformly distributed from 0", 0.0)
    duplicate: Fraction = setting(_CHANCE.format("duplicated"), 0.0)
    reorder: Fraction = setting(_CHANCE.format("reordered"), 0.0)
    corrupt: Fraction = setting(_CHANCE.format("corrupted"), 0.0)
    outages: Annotated[tuple[Pair, ...], Listed] = setting(
        "intervals without frames: begin and length, in s after the first frame", ()
    )
    seed: _Seed = setting("seed of noise and faults", 0)

    @model_validator(mode="after")
    def _check_outages(self) -> Self:
        for k, (begin, length) in enumerate(self.outages):
            if begin < 0 or length <= 0:
                problem = "must begin at 0 s or later and have a positive length"
                problem += f", not {begin!r} s and {length!r} s"
                raise SettingError(problem, key=f"outages[{k}]")
        return self

    @property
    def any(self) -> bool:
        """Whether any fault is set."""
        chances = (self.loss, self.delay, self.jitter, self.duplicate, self.reorder, self.corrupt)
        return any(chances) or bool(self.outages)


class SensorSettings(Table):
    """Noise and resolution of the emulated sensors (default: perfect sensors)."""

    joint_counts: Positive = setting("counts of the joint encoders per rad or m", math.inf)
    length_counts: Positive = setting("counts of the cable encoders per m", math.inf)
    noise: FromZero = setting(
        "standard deviation of positions and lengths, in rad or m, and of velocities", 0.0
    )
    tension_noise: FromZero = setting("relative standard deviation of tensions", 0.0)
    length_offset: tuple[float, ...] = named_setting(
        "muscle", "offset of the length measurement, in m", 0.0
    )
    differentiate_positions: bool = setting("compute velocities from position differences", False)
    seed: _Seed = setting("seed of noise and faults", 0)

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """Return the table as plain data, without offsets if all are zero."""
        without = () if any(self.length_offset) else ("length_offset",)
        return super().data([*leave_out, *without])


FailureKind = Literal[
    "broken",
    "jammed",
    "weak",
    "off_pulley",
    "length_stuck",
    "length_bias",
    "length_drift",
    "length_scale",
    "length_swapped",
    "tension_stuck",
    "tension_dead",
    "encoder_stuck",
]
_FAILURE_VALUES = {
    "jammed": "stiffness of the cable, in N/m",
    "weak": "factor of the force",
    "off_pulley": "change of the length, in m",
    "length_bias": "offset, in m",
    "length_drift": "rate of the offset, in m/s",
    "length_scale": "factor of length changes",
}


class FailureSettings(Table):
    """Failure of a cable, a motor or a sensor of an emulated robot."""

    kind: FailureKind = setting("kind of the failure")
    part: Text = setting("the muscle; for encoder_stuck, the joint coordinate")
    time: FromZero = setting("time of the failure, in s after the start")
    value: float = setting(
        "; ".join(f"{kind}: {meaning}" for kind, meaning in _FAILURE_VALUES.items()), None
    )
    other: Text = setting("length_swapped: the other muscle", None)

    @model_validator(mode="after")
    def _check_failure(self) -> Self:
        for key, required in (
            ("value", self.kind in _FAILURE_VALUES),
            ("other", self.kind == "length_swapped"),
        ):
            if (getattr(self, key) is None) == required:
                problem = "missing; it is required" if required else "is unused"
                raise SettingError(f"{problem} for kind {self.kind!r}", key=key)
        return self

    @property
    def is_of_coordinate(self) -> bool:
        """Whether the part is a joint coordinate instead of a muscle."""
        return self.kind == "encoder_stuck"

    @property
    def kind_of_part(self) -> str:
        """Kind of the part, for messages."""
        return "coordinate" if self.is_of_coordinate else "muscle"


class EmulatorSettings(Faults, SensorSettings):
    """Imperfections of an emulated robot and of its link."""

    motor_lag: FromZero = setting("time constant of the motors, in s", 0.0)
    failures: Annotated[tuple[FailureSettings, ...], Listed] = setting(
        "failures: tables [[hardware.emulator.failures]]", ()
    )


class LinkSettings(Table):
    """Address and timing of the hardware."""

    link: Text = setting("address of the hardware, such as udp://127.0.0.1:5005", "")
    use: bool = setting("drive the hardware instead of the plant in runs", False)
    mode: Mode = setting(
        "realtime, or lockstep: the device computes one step per command", "realtime"
    )
    bind: Text = setting("local address to send from", "")
    key_file: File = setting("file with the key that signs frames, relative to this file", None)
    max_missed: Annotated[int, Field(ge=0), AS_WHOLE] = setting(
        "maximum number of consecutive exchanges without a new state", 10
    )
    watchdog: Positive = setting(
        "time without a command after which the device enters its safe state, in s "
        "(default: 0.02, at least 5 steps)",
        _WATCHDOG,
    )
    timeout: Positive = setting("maximum wait for an answer in lockstep, in s", 1.0)
    scale: Positive = setting("divisor of the transmitted values", 1.0)
    has_positions: bool = setting(
        "joint positions and velocities are measured; false: an estimator provides them", True
    )
    has_lengths: bool = setting("muscle lengths are measured", True)
    has_tensions: bool = setting("tensions and motor torques are measured", True)
    approach: Positive = setting(
        "duration of the motion to the first point of the reference, in s", None
    )


class SafetySettings(Table):
    """Safety limits of the hardware; see `safety.Guard`."""

    ramp_in: FromZero = setting(
        "duration of the ramp from the forces that hold the robot, in s", 0.2
    )
    ramp_down: Annotated[FromZero, Field(le=MAX_RAMP_DOWN)] = setting(
        f"duration of the ramp to f_min at the end, in s; at most {MAX_RAMP_DOWN:g}", 0.5
    )
    force_rate: tuple[Positive, ...] = named_setting(
        "muscle", "maximum force rate, in N/s", None, others=math.inf
    )
    torque_rate: tuple[Positive, ...] = named_setting(
        "motor", "maximum torque rate, in N·m/s or N/s", None, others=math.inf
    )
    max_tension: tuple[Positive, ...] = named_setting(
        "muscle", "tension that stops the run, in N", None, others=math.inf
    )
    position_margin: tuple[FromZero, ...] = named_setting(
        "coordinate", "allowed distance beyond the joint limits, in rad or m", 0.05
    )
    start_tolerance: tuple[FromZero, ...] = named_setting(
        "coordinate", "maximum distance from the start pose, in rad or m", 0.1
    )


class HardwareSettings(SafetySettings, LinkSettings):
    """Hardware that runs instead of the plant."""

    motors: MotorSettings = setting("motor commands", {})
    emulator: EmulatorSettings = setting("imperfections of an emulated robot", {})

    @property
    def is_emulated(self) -> bool:
        """Whether the hardware is an emulated robot in simulated time."""
        return self.link.partition(":")[0] == "emulated"

    @property
    def is_paced(self) -> bool:
        """Whether the hardware runs in real time and does not wait for commands."""
        return self.mode == "realtime"

    @property
    def moves_in_real_time(self) -> bool:
        """Whether runs with the hardware are in real time."""
        return self.is_paced and not self.is_emulated

    def states(self, coordinates: int, muscles: int, motors: int = 0) -> int:
        """Return the number of measured values of a state: q, qd, l, tension and torque."""
        values = (
            2 * self.has_positions * coordinates + (self.has_lengths + self.has_tensions) * muscles
        )
        return values + self.has_tensions * motors


def read_hardware(data: Mapping[str, Any], context: Context, step: float) -> HardwareSettings:
    """Read the table [hardware]; every key has a default."""
    watchdog = max(_WATCHDOG, _WATCHDOG_STEPS * step)
    settings = HardwareSettings.read({"watchdog": watchdog, **data}, context, "hardware")
    if settings.is_paced and settings.watchdog < 2.0 * step:
        problem = f"must be at least twice run.step ({step!r} s), not {settings.watchdog!r} s"
        raise context.error("hardware.watchdog", problem)
    if settings.approach is not None:
        key = "hardware.approach"
        require_multiple(settings.approach, step, "run.step", file=context.file, key=key)
    if settings.emulator.any and settings.link.startswith("loopback"):
        problem = "loopback: does not support faults; set hardware.link to 'emulated:'"
        raise context.error("hardware.emulator", problem)
    if not settings.has_positions:
        if not (settings.has_lengths and settings.has_tensions):
            problem = "a robot without joint encoders requires has_lengths and has_tensions"
            raise context.error("hardware.has_positions", problem)
        if settings.motors.command != "force":
            problem = f"motors with {settings.motors.command} commands require joint velocities"
            raise context.error("hardware.has_positions", problem)
    if settings.max_tension and not settings.has_tensions:
        problem = "requires hardware.has_tensions = true"
        raise context.error("hardware.max_tension", problem)
    return settings


def hardware_data(settings: HardwareSettings, robot: Robot) -> dict[str, Any]:
    """Return the settings of the hardware FMU as plain data.

    The data omits settings on the use of the FMU in runs, and the path of the key file.
    """
    data = settings.data(["use", "key_file", "approach", "emulator"])
    for key in ("link", "bind"):
        if not data[key]:
            del data[key]
    muscles, motors = ([part.name for part in parts] for parts in (robot.muscles, robot.motors))
    for key, names in (("force_rate", muscles), ("torque_rate", motors), ("max_tension", muscles)):
        limits = zip(names, getattr(settings, key), strict=False)
        # JSON has no infinity
        data[key] = {name: limit for name, limit in limits if math.isfinite(limit)}
    emulator = settings.emulator.data()
    return data if emulator == EmulatorSettings().data() else data | {"emulator": emulator}
