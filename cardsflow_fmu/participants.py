"""What the master steps: a model in this process, or an FMU; the same verbs for both."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .models.model import FmuModel

FloatArray = NDArray[np.float64]


class Participant(Protocol):
    """One of the coupled models, initialised and ready to step.

    Attributes:
        name: Its name in the wiring, such as `plant`.
        input_names, output_names: Names of its ports.
        inputs: Written before a step, shape (len(input_names),).
        outputs: Read after a step, shape (len(output_names),).
    """

    name: str
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    inputs: FloatArray
    outputs: FloatArray

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h, in [s]; SimulationError if that fails."""

    def close(self) -> None:
        """Release what it holds."""


class DirectParticipant:
    """A model stepped as a plain Python object.

    Args:
        name: Its name in the wiring.
        model: The model; it is initialised.
    """

    def __init__(self, name: str, model: FmuModel) -> None:
        self.name = name
        self.input_names = tuple(p.name for p in model.ports if p.causality == "input")
        self.output_names = tuple(p.name for p in model.ports if p.causality == "output")
        self.inputs = model.inputs
        self.outputs = model.outputs
        self.step = model.step
        model.initialize()

    def close(self) -> None:
        """Nothing to release."""
