"""Signals between the hardware of a robot and its controller: names and units, in order."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.cosim.signals.hardware import MEASURED_TORQUE
from cardsflow_fmu.cosim.signals.muscles import modelled_muscles
from cardsflow_fmu.cosim.signals.ports import (
    TORQUE,
    coordinate_signals,
    force_unit,
    motor_signals,
    muscle_signals,
)
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings, MotorSettings
from cardsflow_fmu.utils.arrays import FloatArray

from .signature import port_signature

Signals = list[tuple[str, str]]


class HardwareSignals(NamedTuple):
    """Signals to and from the hardware."""

    commands: Signals
    states: Signals


def hardware_signals(robot: Robot, settings: HardwareSettings) -> HardwareSignals:
    """Return the signals of a robot. Signals of joint motors follow the signals of muscles.

    Raises:
        InputError: A muscle has a muscle law, so that its command is not a force.
    """
    require_forces(robot)
    prefix, unit = _command_prefix_and_unit(settings.motors)
    states: Signals = []
    for letter, per in (("q", ""), ("qd", "/s")) if settings.has_positions else ():
        units = (f"{c.unit}{per}" for c in robot.coordinates)
        states += zip(coordinate_signals(letter, robot), units, strict=True)
    for is_measured, letter, state_unit in (
        (settings.has_lengths, "l", "m"),
        (settings.has_tensions, "tension", "N"),
    ):
        states += [(name, state_unit) for name in muscle_signals(letter, robot) if is_measured]
    torques = [force_unit(motor) for motor in robot.motors]
    commands = [(name, unit) for name in muscle_signals(prefix, robot)]
    commands += zip(motor_signals(TORQUE, robot), torques, strict=True)
    if settings.has_tensions:
        states += zip(motor_signals(MEASURED_TORQUE, robot), torques, strict=True)
    return HardwareSignals(commands, states)


def require_forces(robot: Robot, file: Path | None = None) -> None:
    """Reject a robot with muscle laws."""
    for k in modelled_muscles(robot):
        muscle = robot.muscles[k]
        custom = muscle.model.custom
        law = muscle.model.kind if custom is None else custom.name
        raise InputError(
            f"hardware requires force commands, but muscle {muscle.name!r} has the muscle law "
            f"{law!r}; remove the law and configure [hardware.motors]",
            file=file,
            key=f"muscles.{muscle.name}.model",
        )


def hardware_signature(robot: Robot, settings: HardwareSettings) -> int:
    """Return the signature of the signals of a robot; see `signature.port_signature`."""
    commands, states = hardware_signals(robot, settings)
    kind = settings.motors.command
    return port_signature(commands, states, command_kind=kind, scale=settings.scale)


def actuator_bounds(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Return lower and upper limits of muscle forces and then motor torques, shape (a,) each."""
    low = [*(m.f_min for m in robot.muscles), *(c.tau_min for c in robot.motors)]
    high = [*(m.f_max for m in robot.muscles), *(c.tau_max for c in robot.motors)]
    return np.array(low), np.array(high)


def _command_prefix_and_unit(motors: MotorSettings) -> tuple[str, str]:
    if motors.command == "force":
        return "f", "N"
    letter, unit = ("theta", "rad") if motors.spindle_radius else ("l0", "m")
    if motors.encoder_scale:
        unit = "count"
    return (letter, unit) if motors.command == "length" else (f"{letter}d", f"{unit}/s")
