"""What an experiment says of its hardware: where it is, how it is timed, what it may never do."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, get_args

from cardsflow_fmu.hardware.emulator.faults import Faults
from cardsflow_fmu.hardware.emulator.sensors import SensorSettings

CommandKind = Literal["force", "length", "velocity"]
COMMAND_KINDS: tuple[CommandKind, ...] = get_args(CommandKind)

Mode = Literal["realtime", "lockstep"]
MODES: tuple[Mode, ...] = get_args(Mode)

LONGEST_RAMP_DOWN = 3.0
"""In [s]; hosts of FMUs wait for some 5 s until they end a worker process by force."""


@dataclass(frozen=True, slots=True)
class MotorSettings:
    """What the motors take; see `motors.MotorMap`.

    Attributes:
        command: Forces, or set points l0 of springs, or the rates of these.
        stiffness: K, one a muscle, in [N/m]; empty where forces are taken.
        damping: D, one a muscle, in [N·s/m]; empty where forces are taken.
        spindle_radius: r, one a muscle, in [m], where motors take angles; empty for lengths.
        encoder_scale: Counts per [m], or per [rad], one a muscle; empty for SI units.
        offset: The set point l0 at which the motors count 0, one a muscle, in [m]; None to take
            those of the state at the start.
    """

    command: CommandKind = "force"
    stiffness: tuple[float, ...] = ()
    damping: tuple[float, ...] = ()
    spindle_radius: tuple[float, ...] = ()
    encoder_scale: tuple[float, ...] = ()
    offset: tuple[float, ...] | None = ()


@dataclass(frozen=True, slots=True)
class SafetySettings:
    """What is kept from the hardware; see `safety.Guard`.

    Attributes:
        ramp_in: How long it takes from the forces that hold the robot to those wanted, in [s].
        ramp_down: How long they take to fall to f_min at the end, in [s].
        force_rate: Largest change of a force, one a muscle, in [N/s].
        tension_max: Measured tension that ends a run, one a muscle, in [N].
        position_margin: How far beyond its limits a joint may come, one a coordinate, in [rad] or
            [m].
        start_tolerance: How far from the start of the experiment a joint may be, one a coordinate,
            in [rad] or [m].
    """

    ramp_in: float = 0.2
    ramp_down: float = 0.5
    force_rate: tuple[float, ...] = ()
    tension_max: tuple[float, ...] = ()
    position_margin: tuple[float, ...] = ()
    start_tolerance: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class EmulatorSettings:
    """What is imperfect about an emulated robot at `emulated:` or `loopback:`, and its line.

    Attributes:
        motor_lag: Time constant of the motors, in [s].
        sensors: How good the sensors are.
        faults: What happens to frames of `emulated:` on their way.
    """

    motor_lag: float = 0.0
    sensors: SensorSettings = field(default_factory=SensorSettings)
    faults: Faults = field(default_factory=Faults)


@dataclass(frozen=True, slots=True)
class HardwareSettings:
    """The hardware of an experiment.

    Attributes:
        link: Where it is, such as `udp://127.0.0.1:5005`; empty if nothing tells.
        use: Whether runs drive it instead of the plant.
        mode: Whether steps are paced by the clock, or the device takes a step for each command.
        bind: Own address to bind to; empty for the link's own choice.
        key_file: File of the key that frames are signed with; None for the environment's choice.
        max_missed: Exchanges in a row that may bring no new state.
        watchdog: Without a command for so long the device goes to its safe state, in [s].
        timeout: Longest wait for an answer in lock step, in [s].
        scale: Values travel divided by it.
        has_lengths: Whether the device measures path lengths; they are computed otherwise.
        has_tensions: Whether the device measures tensions.
        approach: How long the reference leads from the measured state to its own beginning, in [s];
            None to refuse to start far from there.
        safety: What is kept from the hardware.
        motors: What the motors take.
        emulator: What is imperfect about an emulated robot.
    """

    link: str = ""
    use: bool = False
    mode: Mode = "realtime"
    bind: str = ""
    key_file: Path | None = None
    max_missed: int = 10
    watchdog: float = 0.02
    timeout: float = 1.0
    scale: float = 1.0
    has_lengths: bool = True
    has_tensions: bool = True
    approach: float | None = None
    safety: SafetySettings = field(default_factory=SafetySettings)
    motors: MotorSettings = field(default_factory=MotorSettings)
    emulator: EmulatorSettings = field(default_factory=EmulatorSettings)

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

    def states(self, coordinates: int, muscles: int) -> int:
        """Number of values of a state: q, qd, and what is measured of l and tension."""
        return 2 * coordinates + (self.has_lengths + self.has_tensions) * muscles


def is_limited(values: tuple[float, ...]) -> bool:
    """Whether any of the limits is one."""
    return any(math.isfinite(value) for value in values)
