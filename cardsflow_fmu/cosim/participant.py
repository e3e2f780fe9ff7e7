"""Participants of a co-simulation: connected inputs and outputs, and the methods for the master."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import IntEnum
from typing import NamedTuple, Protocol

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu.cosim.signals.port import Port
from cardsflow_fmu.cosim.signals.units import KNOWN_UNITS, Conversion, Unit
from cardsflow_fmu.utils.arrays import FloatArray


class Form(IntEnum):
    """Conversion of a copied value, as in csrc/master.h."""

    EXACT = 0
    """The value itself."""
    SCALED = 1
    """factor · value + offset."""
    UNSCALED = 2
    """(value - offset) / factor."""


class Copy(NamedTuple):
    """Copy of a value between arrays."""

    source: FloatArray
    source_index: int
    target: FloatArray
    target_index: int
    form: Form = Form.EXACT
    change: Conversion = Conversion()


class CStep(NamedTuple):
    """C function that steps a participant: `int step(void *instance, double t, double h)`.

    Attributes:
        function: Address of the function.
        instance: Address of its first argument.
        failure: Function that returns the error for a result other than 0, and the time of the
            step in [s].
    """

    function: int
    instance: int
    failure: Callable[[int, float], CardsflowError]


class Wired(Protocol):
    """Inputs and outputs of a participant.

    Attributes:
        name: Name of the participant in the wiring, such as `plant`.
        input_names, output_names: Names of the ports. Each element of an array has a name: `q[1]`,
            `q[2]`.
        units: Units of ports, by name; ports without an entry have no unit.
        inputs: Values that are written before a step, shape (len(input_names),); initially the
            start values.
        outputs: Values that are read after a step, shape (len(output_names),).
    """

    name: str
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    units: Mapping[str, Unit]
    inputs: FloatArray
    outputs: FloatArray


class Participant(Wired, Protocol):
    """Initialised model in a co-simulation.

    These attributes are optional: `c_step`, a `CStep` that is used instead of `step`; `incoming`
    and `outgoing`, lists of `Copy` to make before and after each step; `warnings`, assumptions,
    one line each.
    """

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h, in [s]; raise SimulationError on failure."""

    def close(self) -> None:
        """Release all resources."""


class WiredPorts:
    """Inputs and outputs of a model, which share its memory."""

    def __init__(
        self, name: str, ports: Sequence[Port], inputs: FloatArray, outputs: FloatArray
    ) -> None:
        self.name = name
        self.input_names = tuple(p.name for p in ports if p.causality == "input")
        self.output_names = tuple(p.name for p in ports if p.causality == "output")
        self.units: Mapping[str, Unit] = {p.name: KNOWN_UNITS[p.unit] for p in ports if p.unit}
        self.inputs, self.outputs = inputs, outputs


class Idle:
    """Participant that is connected but never stepped."""

    def step(self, t: float, h: float) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing, since there are no resources."""
