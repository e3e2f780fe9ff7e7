"""FMU variables, and their names after joints, muscles and task frames."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.identifier import identifier as identifier

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


def motor_signals(prefix: str, robot: Robot) -> list[str]:
    """`prefix.<coordinate>` for every motor, in the order of q."""
    return signal_names(prefix, [motor.name for motor in robot.motors])


def muscle_signals(prefix: str, robot: Robot) -> list[str]:
    """`prefix.<muscle>` for every muscle, in the order of f."""
    return signal_names(prefix, [muscle.name for muscle in robot.muscles])
