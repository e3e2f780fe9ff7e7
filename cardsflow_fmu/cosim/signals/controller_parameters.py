"""Parameters of a controller: gains and force limits; see `ports`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.trajectory import Space

from .groups import Groups
from .port import (
    Port,
    coordinate_signals,
    effort,
    force_unit,
    motor_signals,
    muscle_ports,
    task_signals,
)


def gain_ports(
    robot: Robot,
    space: Space,
    kp: Sequence[float],
    kd: Sequence[float],
    torque_gains: bool,
) -> Groups:
    """Return the position and velocity gains; see `controller_groups`."""
    signals = coordinate_signals if space == "joint" else task_signals
    groups = {}
    for prefix, unit, per, motion, values in (
        ("kp", "1/s2", "", "Position", kp),
        ("kd", "1/s", ".s", "Velocity", kd),
    ):
        units = [unit] * len(values)
        if torque_gains:
            units = [f"{force_unit(c)}{per}/{c.unit}" for c in robot.coordinates]
        groups[prefix] = [
            Port(name, u, "parameter", "tunable", f"{motion} gain of {name[3:]}", value, lower=0.0)
            for name, u, value in zip(signals(prefix, robot), units, values, strict=True)
        ]
    return groups


def bound_ports(robot: Robot) -> Groups:
    """Return the force limits of muscles, then those of motors."""
    return {
        f"f_{side}": [
            *_muscle_bounds(robot, f"f_{side}", bound),
            *_motor_bounds(robot, f"tau_{side}", bound),
        ]
        for side, bound in (("min", "Smallest"), ("max", "Largest"))
    }


def _muscle_bounds(robot: Robot, prefix: str, bound: str) -> list[Port]:
    muscles, text = range(len(robot.muscles)), f"{bound} force of muscle"
    ports = muscle_ports(prefix, "N", text, robot, "parameter", muscles, "tunable")
    return [
        replace(port, start=min(getattr(muscle, prefix), sys.float_info.max), lower=0.0)
        for port, muscle in zip(ports, robot.muscles, strict=True)
    ]


def _motor_bounds(robot: Robot, prefix: str, bound: str) -> list[Port]:
    limit = sys.float_info.max
    return [
        Port(name, force_unit(c), "parameter", "tunable", description, value)
        for name, c in zip(motor_signals(prefix, robot), robot.motors, strict=True)
        for description in [f"{bound} {effort(c).lower()} of the motor of {c.name}"]
        for value in [min(max(getattr(c, prefix), -limit), limit)]
    ]
