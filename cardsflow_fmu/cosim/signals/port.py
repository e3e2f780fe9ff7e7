"""FMU variables, named after joints, muscles and task frames."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from addin_sdfusion.robot import Coordinate, InputError, Robot
from addin_sdfusion.robot.identifier import identifier as identifier

Causality = Literal["input", "output", "parameter", "local"]
Variability = Literal["continuous", "discrete", "fixed", "tunable"]

_NOMINALS = {"m": 0.1}  # of positions, lengths and fibres; 1 in every other unit


@dataclass(frozen=True, slots=True)
class Port:
    """Variable of an FMU.

    Attributes:
        name: Structured name, such as `q.elbow`.
        unit: Unit, such as `rad`; empty for a number without a unit.
        causality: `input`, `output` or `parameter`; `local` for parts of a model in continuous
            time.
        variability: `continuous` or `discrete` signals; `fixed` or `tunable` parameters.
        start: Start value of an input or a parameter.
        boolean: Whether the variable is a boolean, stored as 0 or 1.
        lower, upper: Range in which the variable is intended to be; infinite if unlimited.
        nominal: Typical magnitude, from which solvers derive absolute tolerances.
    """

    name: str
    unit: str
    causality: Causality
    variability: Variability
    description: str
    start: float = 0.0
    boolean: bool = False
    lower: float = -math.inf
    upper: float = math.inf
    nominal: float = 1.0


def nominal_of(unit: str) -> float:
    """Return the nominal value of a position, a length or the state of a muscle."""
    return _NOMINALS.get(unit, 1.0)


def time_port(name: str, description: str, start: float) -> Port:
    """Return a parameter that is a positive time, in [s]."""
    return Port(name, "s", "parameter", "fixed", description, start, lower=0.0)


def count_port(name: str, description: str, upper: float = math.inf) -> Port:
    """Return an output that is a number from 0 to `upper`, such as a count."""
    return Port(name, "", "output", "discrete", description, lower=0.0, upper=upper)


def muscle_ports(
    prefix: str,
    unit: str,
    quantity: str,
    robot: Robot,
    causality: Causality,
    muscles: Sequence[int],
    variability: Variability = "continuous",
) -> list[Port]:
    """Return `prefix.<muscle>` of muscles by their indices.

    Args:
        quantity: Beginning of the descriptions, which end with the name of the muscle.
    """
    names = muscle_signals(prefix, robot)
    return [
        Port(names[k], unit, causality, variability, f"{quantity} {robot.muscles[k].name}")
        for k in muscles
    ]


def motor_ports(prefix: str, quantity: str, robot: Robot, causality: Causality) -> list[Port]:
    """Return `prefix.<coordinate>` of every motor, with descriptions like `muscle_ports`."""
    return [
        Port(name, force_unit(c), causality, "continuous", f"{quantity} {c.name}")
        for name, c in zip(motor_signals(prefix, robot), robot.motors, strict=True)
    ]


def signal_names(prefix: str, names: Iterable[str]) -> list[str]:
    """Return port names for coordinates, muscles or other named objects.

    Raises:
        InputError: Two names result in the same port name.
    """
    ports: dict[str, str] = {}
    for name in names:
        port = f"{prefix}.{identifier(name)}"
        if port in ports:
            names_of_both = f"{ports[port]!r} and {name!r}"
            raise InputError(f"{names_of_both} would both be the variable {port!r}; rename one")
        ports[port] = name
    return list(ports)


def coordinate_signals(prefix: str, robot: Robot) -> list[str]:
    """Return `prefix.<coordinate>` for every coordinate, in the order of q."""
    return signal_names(prefix, [c.name for c in robot.coordinates])


def motor_signals(prefix: str, robot: Robot) -> list[str]:
    """Return `prefix.<coordinate>` for every motor, in the order of q."""
    return signal_names(prefix, [motor.name for motor in robot.motors])


def muscle_signals(prefix: str, robot: Robot) -> list[str]:
    """Return `prefix.<muscle>` for every muscle, in the order of f."""
    return signal_names(prefix, [muscle.name for muscle in robot.muscles])


def task_signals(prefix: str, robot: Robot) -> list[str]:
    """Return `prefix.<frame>.<axis>` for every task coordinate, in the order of y."""
    frames = signal_names(prefix, [frame.name for frame in robot.task_frames])
    return [
        f"{name}.{axis}"
        for name, frame in zip(frames, robot.task_frames, strict=True)
        for axis in frame.axes
    ]


def task_units(robot: Robot) -> list[str]:
    """Return the unit of every task coordinate, in the order of y."""
    return [
        "rad" if frame.is_orientation else "m" for frame in robot.task_frames for axis in frame.axes
    ]


def task_names(robot: Robot) -> tuple[str, ...]:
    """Return `<frame>.<axis>` for every task coordinate, in the order of y."""
    return tuple(f"{frame.name}.{axis}" for frame in robot.task_frames for axis in frame.axes)


def load_signals(robot: Robot) -> list[str]:
    """Return `w.<frame>.fx`, `.fy`, `.fz` for every task frame that is a point."""
    points = [frame.name for frame in robot.task_frames if not frame.is_orientation]
    return [f"{name}.f{axis}" for name in signal_names("w", points) for axis in "xyz"]


def force_unit(coordinate: Coordinate) -> str:
    """Return the unit of the generalised force of a coordinate."""
    return "N.m" if coordinate.unit == "rad" else "N"


def effort(coordinate: Coordinate) -> str:
    """Return the kind of the generalised force of a coordinate, for descriptions."""
    return "Torque" if coordinate.unit == "rad" else "Force"
