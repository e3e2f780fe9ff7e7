"""Base class of models in FMUs: variables and a step function, without FMI."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Self

import numpy as np

from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.utils.arrays import FloatArray


class FmuModel(ABC):
    """Model that can be stepped in a Python loop, in a test, or in an FMU.

    All variables are in one flat array, `values`, in the order of `ports`: inputs, outputs,
    parameters. A host writes inputs and parameters to it and reads outputs from it. A model never
    replaces the array, so it may be memory of another program.

    Order of calls: set parameters; `initialize`; any number of `step`. `reset` restores the start
    values.

    Args:
        values: Memory for the variables, shape (len(ports),) (default: allocated).

    Attributes:
        ports: The variables.
        values: Values of the variables.
        inputs, outputs, parameters: Views of `values`.
    """

    description: ClassVar[str] = ""
    """Description in one line, which is part of the FMU."""
    any_step: ClassVar[bool] = False
    """Whether steps may have any length, also different lengths."""
    has_state: ClassVar[bool] = True
    """Whether the model has `get_state` and `set_state`; hardware does not."""

    def __init__(self, ports: Sequence[Port], values: FloatArray | None = None) -> None:
        self.ports = tuple(ports)
        order = ("input", "output", "parameter")
        ranks = [order.index(port.causality) for port in self.ports]
        assert ranks == sorted(ranks), "ports must be in the order inputs, outputs, parameters"
        counts = [ranks.count(rank) for rank in range(3)]
        self.values: FloatArray = np.empty(len(self.ports)) if values is None else values
        assert self.values.shape == (len(self.ports),)
        self.inputs, self.outputs, self.parameters = np.split(
            self.values, [counts[0], counts[0] + counts[1]]
        )
        self._start = np.array([port.start for port in self.ports])
        self.values[:] = self._start

    @classmethod
    @abstractmethod
    def from_resources(cls, folder: Path, values: FloatArray | None = None) -> Self:
        """Create the model from the resources of an FMU."""

    @abstractmethod
    def initialize(self, t: float = 0.0) -> None:
        """Read the parameters, go to the start state and compute its outputs.

        It may be called again before the first step if a parameter has changed.

        Args:
            t: Time at the start, in [s].
        """

    @abstractmethod
    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h with the current inputs.

        Args:
            t: Time at the beginning of the step, in [s].
            h: Length of the step, in [s].

        Raises:
            StepLengthError: The length is impossible, and nothing has changed. The host may try a
                step of another length; other errors end the simulation.
        """

    @abstractmethod
    def get_state(self) -> bytes:
        """Return the state that is not in `values`, as bytes."""

    @abstractmethod
    def set_state(self, state: bytes) -> None:
        """Restore a state from `get_state`; raise an error for a wrong number of bytes."""

    def reset(self) -> None:
        """Restore the start values; `initialize` must follow."""
        self.values[:] = self._start

    def close(self) -> None:  # noqa: B027 - most models have no resources
        """Release resources outside this process; most models have none.

        An FMU's model is closed when its host terminates the simulation. A second call does
        nothing. Outputs do not change, and `reset` restores the start values.
        """
