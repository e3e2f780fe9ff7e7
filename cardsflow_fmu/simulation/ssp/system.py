"""Systems of FMUs as plain records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cardsflow_fmu.cosim.signals.units import Conversion, Unit


@dataclass(frozen=True, slots=True)
class Connector:
    """Variable of a component that can be connected.

    Attributes:
        kind: `input` or `output`.
        type: Type, such as `Real` or `Boolean`.
        unit: Unit; None for dimensionless variables.
    """

    name: str
    kind: Literal["input", "output"]
    type: str
    unit: Unit | None


@dataclass(frozen=True, slots=True)
class Parameter:
    """Start value of a variable.

    Attributes:
        value: Value; booleans are 0 and 1.
        unit: Unit of the value; None for the unit of the variable.
    """

    name: str
    value: float
    unit: Unit | None = None


@dataclass(frozen=True, slots=True)
class Component:
    """FMU of a system."""

    name: str
    source: str
    connectors: tuple[Connector, ...]
    parameters: tuple[Parameter, ...] = ()


@dataclass(frozen=True, slots=True)
class Connection:
    """Connection of an output to an input."""

    source: tuple[str, str]
    target: tuple[str, str]
    change: Conversion


@dataclass(frozen=True, slots=True)
class System:
    """System of connected FMUs.

    Attributes:
        components: The FMUs.
        connections: Connections of outputs to inputs.
        step: Communication step, in [s]; None if not specified.
        stop_time: Stop time, in [s]; None if not specified.
    """

    name: str
    components: tuple[Component, ...]
    connections: tuple[Connection, ...]
    step: float | None
    stop_time: float | None
