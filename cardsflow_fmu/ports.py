"""The table of FMU variables for a robot: name, unit, causality, start value.

Everything that names a variable (FMUs, wiring, CSV headers, legends) takes the name from here. The
value reference of a port is its index in the table of its model.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from addin_sdfusion.robot import Coordinate, InputError, Robot

Causality = Literal["input", "output", "parameter"]
Variability = Literal["continuous", "discrete", "fixed", "tunable"]


@dataclass(frozen=True, slots=True)
class Port:
    """A variable of an FMU.

    Attributes:
        name: Structured name, such as `q.elbow`.
        unit: Such as `rad`; empty for a number without one.
        causality: `input`, `output` or `parameter`.
        variability: `continuous` or `discrete` signals; `fixed` or `tunable` parameters.
        description: One line for people.
        start: Value of an input or a parameter before it is set.
        boolean: Whether the variable is a truth value, stored as 0 or 1.
    """

    name: str
    unit: str
    causality: Causality
    variability: Variability
    description: str
    start: float = 0.0
    boolean: bool = False


def identifier(name: str) -> str:
    """A designer's name as one part of a structured FMI variable name: `cable 1` -> `cable_1`."""
    cleaned = re.sub(r"\W", "_", name, flags=re.ASCII) or "_"
    return f"_{cleaned}" if cleaned[0].isdigit() else cleaned


def signal_names(prefix: str, names: Iterable[str]) -> list[str]:
    """Port names for a list of coordinates, muscles or other named things.

    Args:
        prefix: Such as `q`.
        names: The designer's names.

    Raises:
        InputError: Two names give the same port name.
    """
    ports: dict[str, str] = {}
    for name in names:
        port = f"{prefix}.{identifier(name)}"
        if port in ports:
            raise InputError(f"{ports[port]!r} and {name!r} would both be {port!r}: rename one")
        ports[port] = name
    return list(ports)


def coordinate_signals(prefix: str, robot: Robot) -> list[str]:
    """`prefix.<coordinate>` for every coordinate, in the order of q."""
    return signal_names(prefix, [c.name for c in robot.coordinates])


def muscle_signals(prefix: str, robot: Robot) -> list[str]:
    """`prefix.<muscle>` for every muscle, in the order of f."""
    return signal_names(prefix, [muscle.name for muscle in robot.muscles])


def task_signals(prefix: str, robot: Robot) -> list[str]:
    """`prefix.<frame>.<axis>` for every task coordinate, in the order of y."""
    frames = signal_names(prefix, [frame.name for frame in robot.task_frames])
    return [
        f"{name}.{axis}"
        for name, frame in zip(frames, robot.task_frames, strict=True)
        for axis in frame.axes
    ]


def task_units(robot: Robot) -> list[str]:
    """The unit of every task coordinate, in the order of y."""
    return [
        "rad" if frame.is_orientation else "m" for frame in robot.task_frames for axis in frame.axes
    ]


def force_unit(coordinate: Coordinate) -> str:
    """Unit of the generalised force of a coordinate."""
    return "N.m" if coordinate.unit == "rad" else "N"


def _coordinate_ports(
    prefix: str,
    per: str,
    what: str,
    robot: Robot,
    causality: Causality,
    variability: Variability,
    start: Sequence[float] | None = None,
) -> list[Port]:
    """A port a coordinate; its unit is the coordinate's, followed by `per`."""
    starts = start or [0.0] * len(robot.coordinates)
    return [
        Port(name, c.unit + per, causality, variability, f"{what} of {c.name}", value)
        for name, c, value in zip(
            coordinate_signals(prefix, robot), robot.coordinates, starts, strict=True
        )
    ]


def _force_ports(robot: Robot, causality: Causality, variability: Variability) -> list[Port]:
    return [
        Port(name, "N", causality, variability, f"Force of muscle {muscle.name}")
        for name, muscle in zip(muscle_signals("f", robot), robot.muscles, strict=True)
    ]


def plant_ports(robot: Robot, q: Sequence[float], qd: Sequence[float], step: float) -> list[Port]:
    """Ports of the plant: forces in; positions, velocities, muscle lengths and task points out.

    Args:
        robot: The robot.
        q: Positions at the start, in [rad] or [m].
        qd: Velocities at the start, in [rad/s] or [m/s].
        step: Internal step, in [s].
    """
    return [
        *_force_ports(robot, "input", "continuous"),
        *_coordinate_ports("q", "", "Position", robot, "output", "continuous"),
        *_coordinate_ports("qd", "/s", "Velocity", robot, "output", "continuous"),
        *(
            Port(name, "m", "output", "continuous", f"Path length of muscle {muscle.name}")
            for name, muscle in zip(muscle_signals("l", robot), robot.muscles, strict=True)
        ),
        *(
            Port(name, unit, "output", "continuous", f"Task coordinate {name[2:]}")
            for name, unit in zip(task_signals("y", robot), task_units(robot), strict=True)
        ),
        *_coordinate_ports("q_start", "", "Start position", robot, "parameter", "fixed", q),
        *_coordinate_ports("qd_start", "/s", "Start velocity", robot, "parameter", "fixed", qd),
        Port("step", "s", "parameter", "fixed", "Internal step of the plant", step),
    ]


def reference_ports(robot: Robot) -> list[Port]:
    """Ports of a joint-space reference: desired positions, velocities and accelerations out."""
    return [
        *_coordinate_ports("q_d", "", "Desired position", robot, "output", "continuous"),
        *_coordinate_ports("qd_d", "/s", "Desired velocity", robot, "output", "continuous"),
        *_coordinate_ports("qdd_d", "/s2", "Desired acceleration", robot, "output", "continuous"),
    ]


def joint_controller_ports(
    robot: Robot, kp: Sequence[float], kd: Sequence[float], period: float
) -> list[Port]:
    """Ports of a joint-space controller: state and reference in; forces and diagnostics out.

    Args:
        robot: The robot.
        kp: Position gains, in [1/s²].
        kd: Velocity gains, in [1/s].
        period: Time between two ticks, in [s].
    """
    gains = [
        Port(name, unit, "parameter", "tunable", f"{what} gain of {c.name}", value)
        for prefix, unit, what, values in (
            ("kp", "1/s2", "Position", kp),
            ("kd", "1/s", "Velocity", kd),
        )
        for name, c, value in zip(
            coordinate_signals(prefix, robot), robot.coordinates, values, strict=True
        )
    ]
    bounds = [
        Port(name, "N", "parameter", "tunable", f"{what} force of muscle {muscle.name}", value)
        for prefix, what in (("f_min", "Smallest"), ("f_max", "Largest"))
        for name, muscle in zip(muscle_signals(prefix, robot), robot.muscles, strict=True)
        for value in [min(getattr(muscle, prefix), sys.float_info.max)]
    ]
    return [
        *_coordinate_ports("q", "", "Position", robot, "input", "continuous"),
        *_coordinate_ports("qd", "/s", "Velocity", robot, "input", "continuous"),
        *_coordinate_ports("q_d", "", "Desired position", robot, "input", "continuous"),
        *_coordinate_ports("qd_d", "/s", "Desired velocity", robot, "input", "continuous"),
        *_coordinate_ports("qdd_d", "/s2", "Desired acceleration", robot, "input", "continuous"),
        *_force_ports(robot, "output", "discrete"),
        *(
            Port(name, force_unit(c), "output", "discrete", f"Missing force or torque of {c.name}")
            for name, c in zip(coordinate_signals("slack", robot), robot.coordinates, strict=True)
        ),
        Port(
            "infeasible", "", "output", "discrete", "No force within the bounds fits", boolean=True
        ),
        *gains,
        *bounds,
        Port("period", "s", "parameter", "fixed", "Time between two ticks", period),
    ]
