"""Participants of a co-simulation: wired inputs and outputs, and the verbs of the master."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from cardsflow_fmu.cosim.signals.port import Port
from cardsflow_fmu.cosim.signals.units import KNOWN_UNITS, Unit
from cardsflow_fmu.utils.arrays import FloatArray


class Wired(Protocol):
    """Inputs and outputs as the wiring sees them.

    Attributes:
        name: Its name in the wiring, such as `plant`.
        input_names, output_names: Names of its ports. Elements of an array stand one after another,
            each with a name of its own: `q[1]`, `q[2]`.
        units: Units of ports, by name; ports without an entry have none.
        inputs: Written before a step, shape (len(input_names),); at their start values at first.
        outputs: Read after a step, shape (len(output_names),).
    """

    name: str
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    units: Mapping[str, Unit]
    inputs: FloatArray
    outputs: FloatArray


class Participant(Wired, Protocol):
    """One of the coupled models, initialised and ready to step."""

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h, in [s]; SimulationError if that fails."""

    def close(self) -> None:
        """Release what it holds."""


class WiredPorts:
    """The inputs and outputs of a model's table over its memory.

    Args:
        name: Name in the wiring.
        ports: The table of variables.
        inputs, outputs: The memory, a number a port.
    """

    def __init__(
        self, name: str, ports: Sequence[Port], inputs: FloatArray, outputs: FloatArray
    ) -> None:
        self.name = name
        self.input_names = tuple(p.name for p in ports if p.causality == "input")
        self.output_names = tuple(p.name for p in ports if p.causality == "output")
        self.units: Mapping[str, Unit] = {p.name: KNOWN_UNITS[p.unit] for p in ports if p.unit}
        self.inputs, self.outputs = inputs, outputs


class Idle:
    """The verbs of a participant that is wired, and never stepped."""

    def step(self, t: float, h: float) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing: it holds nothing."""
