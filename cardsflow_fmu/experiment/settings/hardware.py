"""[hardware]: what can be driven instead of the plant, how it is timed, what it may never do."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from addin_sdfusion.robot import Robot
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.multiples import require_multiple
from cardsflow_fmu.experiment.config.names import each
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

LONGEST_RAMP_DOWN = 3.0
"""In [s]; hosts of FMUs wait for some 5 s until they end a worker process by force."""

_WATCHDOG, _WATCHDOG_STEPS = 0.02, 5
_CHANCE = "chance of a frame on its way, from 0 to 1"
_Seed = Annotated[int, Field(ge=0), AS_WHOLE]


class MotorSettings(Table):
    """What the motors take; see `motors.MotorMap`."""

    command: CommandKind = setting("forces, lengths or velocities", "force")
    stiffness: tuple[Positive, ...] = each("muscle", "of the springs, in N/m", None)
    damping: tuple[FromZero, ...] = each("muscle", "of the springs, in N·s/m", 0.0)
    spindle_radius: tuple[Positive, ...] = each("muscle", "where motors take angles, in m", None)
    encoder_scale: tuple[Positive, ...] = each(
        "muscle", "counts per rad with a spindle_radius, else per m", None
    )
    offset: tuple[float, ...] | None = each(
        "muscle",
        "set point where the motors count 0, in m; that of the start",
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
        """As of any table; of motors that take forces, that alone."""
        if self.command == "force":
            return {"command": "force"}
        absent = [key for key in ("spindle_radius", "encoder_scale") if not getattr(self, key)]
        return {"offset": "start", **super().data([*leave_out, *absent])}


class Faults(Table):
    """What happens to frames of `emulated:`, in each direction; nothing by default."""

    loss: Fraction = setting(_CHANCE, 0.0)
    delay: FromZero = setting("of every frame, in s", 0.0)
    jitter: FromZero = setting("longest further delay, in s; even between 0 and this", 0.0)
    duplicate: Fraction = setting(_CHANCE, 0.0)
    reorder: Fraction = setting(_CHANCE, 0.0)
    corrupt: Fraction = setting(_CHANCE, 0.0)
    outages: Annotated[tuple[Pair, ...], Listed] = setting(
        "when no frame comes through: begin and length, in s from the first frame on", ()
    )
    seed: _Seed = setting("of noise and faults", 0)

    @model_validator(mode="after")
    def _check_outages(self) -> Self:
        for k, (begin, length) in enumerate(self.outages):
            if begin < 0 or length <= 0:
                what = f"begins at 0 s or later and lasts, not {begin!r} s and {length!r} s"
                raise SettingError(f"an outage {what}", key=f"outages[{k}]")
        return self

    @property
    def any(self) -> bool:
        """Whether anything happens at all."""
        chances = (self.loss, self.delay, self.jitter, self.duplicate, self.reorder, self.corrupt)
        return any(chances) or bool(self.outages)


class SensorSettings(Table):
    """How good the sensors are; perfect by default."""

    joint_counts: Positive = setting("counts a radian or metre of the joints' encoders", math.inf)
    length_counts: Positive = setting("counts a metre of the cables' encoders", math.inf)
    noise: FromZero = setting(
        "standard deviation of readings: positions and lengths, in rad or m, and velocities", 0.0
    )
    length_offset: tuple[float, ...] = each("muscle", "of a length, in m", 0.0)
    differentiate_positions: bool = setting("compute velocities from position differences", False)
    seed: _Seed = setting("of noise and faults", 0)

    def data(self, leave_out: Collection[str] = ()) -> dict[str, Any]:
        """As of any table; offsets where there are any."""
        without = () if any(self.length_offset) else ("length_offset",)
        return super().data([*leave_out, *without])


class EmulatorSettings(Faults, SensorSettings):
    """What is imperfect about an emulated robot, and its line."""

    motor_lag: FromZero = setting("time constant of the motors, in s", 0.0)

    @property
    def sensors(self) -> SensorSettings:
        """How good the sensors are."""
        return self

    @property
    def faults(self) -> Faults:
        """What happens to frames on their way."""
        return self


class LinkSettings(Table):
    """Where the hardware is, and how it is timed."""

    link: Text = setting("where it is, such as udp://127.0.0.1:5005", "")
    use: bool = setting("whether runs drive it instead of the plant", False)
    mode: Mode = setting("lockstep: the device takes a step a command", "realtime")
    bind: Text = setting("address of this machine to send from", "")
    key_file: File = setting("the key that frames are signed with, relative to this file", None)
    max_missed: Annotated[int, Field(ge=0), AS_WHOLE] = setting(
        "exchanges in a row without a new state", 10
    )
    watchdog: Positive = setting(
        "without a command for so long the device is safe, in s; at least 5 steps when left out",
        _WATCHDOG,
    )
    timeout: Positive = setting("longest wait for an answer in lockstep, in s", 1.0)
    scale: Positive = setting("values travel divided by it", 1.0)
    has_positions: bool = setting(
        "whether joints' positions and velocities are measured; else an estimator finds them", True
    )
    has_lengths: bool = setting("whether muscle lengths are measured", True)
    has_tensions: bool = setting("whether tensions, and torques of motors, are measured", True)
    approach: Positive = setting("to where the reference begins, in s", None)


class SafetySettings(Table):
    """What is kept from the hardware; see `safety.Guard`."""

    ramp_in: FromZero = setting("from the forces that hold the robot, in s", 0.2)
    ramp_down: Annotated[FromZero, Field(le=LONGEST_RAMP_DOWN)] = setting(
        "to f_min at the end, in s; hosts of FMUs do not wait for longer", 0.5
    )
    force_rate: tuple[Positive, ...] = each(
        "muscle", "largest change of a force, in N/s", None, others=math.inf
    )
    torque_rate: tuple[Positive, ...] = each(
        "motor", "largest change of a torque, in N·m/s or N/s", None, others=math.inf
    )
    max_tension: tuple[Positive, ...] = each(
        "muscle", "tension that ends a run, in N", None, others=math.inf
    )
    position_margin: tuple[FromZero, ...] = each(
        "coordinate", "beyond the joints' limits, in rad or m", 0.05
    )
    start_tolerance: tuple[FromZero, ...] = each(
        "coordinate", "from the start of the experiment, in rad or m", 0.1
    )


class HardwareSettings(SafetySettings, LinkSettings):
    """What can be driven instead of the plant."""

    motors: MotorSettings = setting("what the motors take", {})
    emulator: EmulatorSettings = setting("what is imperfect about an emulated robot", {})

    @property
    def safety(self) -> SafetySettings:
        """What is kept from the hardware."""
        return self

    @property
    def is_emulated(self) -> bool:
        """Whether it is a computed robot, in a time of its own."""
        return self.link.partition(":")[0] == "emulated"

    @property
    def is_paced(self) -> bool:
        """Whether the hardware goes on by itself, by its clock."""
        return self.mode == "realtime"

    @property
    def goes_by_clock(self) -> bool:
        """Whether runs with the hardware take as long as they are."""
        return self.is_paced and not self.is_emulated

    def states(self, coordinates: int, muscles: int, motors: int = 0) -> int:
        """Number of values of a state: what is measured of q, qd, l, tension and torque."""
        values = (
            2 * self.has_positions * coordinates + (self.has_lengths + self.has_tensions) * muscles
        )
        return values + self.has_tensions * motors


def read_hardware(data: Mapping[str, Any], context: Context, step: float) -> HardwareSettings:
    """What an experiment says of its hardware; everything has a default."""
    watchdog = max(_WATCHDOG, _WATCHDOG_STEPS * step)
    settings = HardwareSettings.read({"watchdog": watchdog, **data}, context, "hardware")
    if settings.is_paced and settings.watchdog < 2.0 * step:
        what = f"{settings.watchdog!r} s is shorter than two of run.step, {step!r} s"
        raise context.error("hardware.watchdog", f"{what}: the device would not keep running")
    if settings.approach is not None:
        key = "hardware.approach"
        require_multiple(settings.approach, step, "run.step", file=context.file, key=key)
    if settings.emulator.any and settings.link.startswith("loopback"):
        what = "frames of loopback: meet no faults; use link = 'emulated:'"
        raise context.error("hardware.emulator", what)
    if not settings.has_positions:
        if not (settings.has_lengths and settings.has_tensions):
            what = "poses without joint encoders come from lengths and tensions: measure both"
            raise context.error("hardware.has_positions", what)
        if settings.motors.command != "force":
            what = f"motors that take a {settings.motors.command} need the joints' velocities"
            raise context.error("hardware.has_positions", what)
    if settings.max_tension and not settings.has_tensions:
        what = "limits what has_tensions = false says is not measured"
        raise context.error("hardware.max_tension", what)
    return settings


def hardware_data(settings: HardwareSettings, robot: Robot) -> dict[str, Any]:
    """What the hardware's FMU needs to know, as plain data that reads back as the same.

    Whether and how runs use the FMU is not of it, and no word leads to a key.
    """
    data = settings.data(["use", "key_file", "approach", "emulator"])
    for key in ("link", "bind"):
        if not data[key]:
            del data[key]
    muscles, motors = ([part.name for part in parts] for parts in (robot.muscles, robot.motors))
    for key, names in (("force_rate", muscles), ("torque_rate", motors), ("max_tension", muscles)):
        limits = zip(names, getattr(settings, key), strict=False)
        # no number is infinity in JSON
        data[key] = {name: limit for name, limit in limits if math.isfinite(limit)}
    emulator = settings.emulator.data()
    return data if emulator == EmulatorSettings().data() else data | {"emulator": emulator}
