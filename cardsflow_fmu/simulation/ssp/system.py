"""Systems of FMUs as plain records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cardsflow_fmu.cosim.signals.units import Conversion, Unit


@dataclass(frozen=True, slots=True)
class Connector:
    """A variable of a component that connections may reach.

    Attributes:
        name: The variable's.
        kind: `input` or `output`.
        type: Such as `Real` or `Boolean`.
        unit: Its unit; None if it has none.
    """

    name: str
    kind: Literal["input", "output"]
    type: str
    unit: Unit | None


@dataclass(frozen=True, slots=True)
class Parameter:
    """A start value.

    Attributes:
        name: The variable's.
        value: Its value; truth values are 0 and 1.
        unit: The unit that the value is in; None if it is the variable's own.
    """

    name: str
    value: float
    unit: Unit | None = None


@dataclass(frozen=True, slots=True)
class Component:
    """An FMU of a system.

    Attributes:
        name: Its name in the system.
        source: Path of the FMU below the archive's root.
        connectors: Its inputs and outputs.
        parameters: Its start values.
    """

    name: str
    source: str
    connectors: tuple[Connector, ...]
    parameters: tuple[Parameter, ...] = ()


@dataclass(frozen=True, slots=True)
class Connection:
    """An output that feeds an input; both as name of the component and of the connector.

    Attributes:
        source, target: The two ends.
        change: Conversion of the value.
    """

    source: tuple[str, str]
    target: tuple[str, str]
    change: Conversion


@dataclass(frozen=True, slots=True)
class System:
    """FMUs and how they feed each other.

    Attributes:
        name: Its name.
        components: The FMUs.
        connections: Of outputs to inputs.
        step: Communication step, in [s]; None if nothing says.
        stop_time: End, in [s]; None if nothing says.
    """

    name: str
    components: tuple[Component, ...]
    connections: tuple[Connection, ...]
    step: float | None
    stop_time: float | None
