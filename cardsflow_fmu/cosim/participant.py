"""The participant protocol: what the master steps, a model in this process or an FMU."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from cardsflow_fmu.signals.units import Unit
from cardsflow_fmu.utils.arrays import FloatArray


class Participant(Protocol):
    """One of the coupled models, initialised and ready to step.

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

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h, in [s]; SimulationError if that fails."""

    def close(self) -> None:
        """Release what it holds."""
