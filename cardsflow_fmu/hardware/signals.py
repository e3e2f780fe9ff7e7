"""The signals between a robot's hardware and those who drive it: names and units, in order."""

from __future__ import annotations

from typing import NamedTuple

from addin_sdfusion.robot import Robot
from cardsflow_fmu.ports import coordinate_signals, muscle_signals

from .settings import HardwareSettings, MotorSettings
from .signature import port_signature

Signals = list[tuple[str, str]]


class HardwareSignals(NamedTuple):
    """What goes to the hardware, and what comes back.

    Attributes:
        commands: Name and unit of each value of a set point.
        states: Name and unit of each value of a state.
    """

    commands: Signals
    states: Signals


def hardware_signals(robot: Robot, settings: HardwareSettings) -> HardwareSignals:
    """The signals of a robot.

    Args:
        robot: The robot.
        settings: What its motors take, and what it measures.
    """
    prefix, unit = _command(settings.motors)
    states = [
        *zip(coordinate_signals("q", robot), (c.unit for c in robot.coordinates), strict=True),
        *zip(
            coordinate_signals("qd", robot), (f"{c.unit}/s" for c in robot.coordinates), strict=True
        ),
    ]
    for measured, letter, its_unit in (
        (settings.has_lengths, "l", "m"),
        (settings.has_tensions, "tension", "N"),
    ):
        states += [(name, its_unit) for name in muscle_signals(letter, robot) if measured]
    return HardwareSignals([(name, unit) for name in muscle_signals(prefix, robot)], states)


def hardware_signature(robot: Robot, settings: HardwareSettings) -> int:
    """The number that a device of this robot answers to.

    Args:
        robot: The robot.
        settings: What its motors take, what it measures, and the scale.
    """
    commands, states = hardware_signals(robot, settings)
    kind = settings.motors.command
    return port_signature(commands, states, command_kind=kind, scale=settings.scale)


def _command(motors: MotorSettings) -> tuple[str, str]:
    """First part of the commands' names, and their unit."""
    if motors.command == "force":
        return "f", "N"
    letter, unit = ("theta", "rad") if motors.spindle_radius else ("l0", "m")
    if motors.encoder_scale:
        unit = "count"
    return (letter, unit) if motors.command == "length" else (f"{letter}d", f"{unit}/s")
