"""The base of the models in FMUs: a plain class with ports and a step, without any FMI."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Self

import numpy as np

from addin_sdfusion.robot import InputError, SimulationError
from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.utils.arrays import FloatArray

from .derivatives import Indices, directional_derivative


class FmuModel(ABC):
    """A model that can be stepped in a plain Python loop, in a test, or inside an FMU.

    All variables stand in one flat array, `values`, in the order of `ports`: inputs, then outputs,
    then parameters. A host writes inputs and parameters there and reads outputs from there; a model
    never replaces the array, so that it may be another program's memory.

    The order of calls: parameters are set; `initialize`; then any number of `step`. `reset` leads
    back to the beginning.

    Args:
        ports: The table of variables.
        values: Memory for the variables, shape (len(ports),); allocated when None.

    Attributes:
        ports: The table of variables.
        values: Their values.
        inputs, outputs, parameters: Views of `values`.
        states: Indices of outputs that are states, which `set_states` takes.
        steady_outputs: Indices of outputs whose derivative is zero wherever there is one: numbers
            that are counted, times that are measured.
        ranges: Of every variable the smallest and the largest value that acts, shapes
            (len(ports),); what lies beyond acts as these. Infinite for most.
    """

    description: ClassVar[str] = ""
    """One line for people, written into the FMU."""
    any_step: ClassVar[bool] = False
    """Whether steps may have any length, and another one every time."""
    has_derivatives: ClassVar[bool] = False
    """Whether `directional_derivative` answers."""
    has_state: ClassVar[bool] = True
    """Whether `get_state` and `set_state` do: what goes on in the world does not go back."""

    def __init__(self, ports: Sequence[Port], values: FloatArray | None = None) -> None:
        self.ports = tuple(ports)
        order = ("input", "output", "parameter")
        ranks = [order.index(port.causality) for port in self.ports]
        assert ranks == sorted(ranks), "ports stand in the order inputs, outputs, parameters"
        counts = [ranks.count(rank) for rank in range(3)]
        self.values: FloatArray = np.empty(len(self.ports)) if values is None else values
        assert self.values.shape == (len(self.ports),)
        self.inputs, self.outputs, self.parameters = np.split(
            self.values, [counts[0], counts[0] + counts[1]]
        )
        self.states: Indices = np.empty(0, dtype=np.intp)
        self.steady_outputs: Indices = np.empty(0, dtype=np.intp)
        endless = np.full(len(self.ports), np.inf)
        self.ranges: tuple[FloatArray, FloatArray] = (-endless, endless)
        self._start = np.array([port.start for port in self.ports])
        self.values[:] = self._start

    @classmethod
    @abstractmethod
    def from_resources(cls, folder: Path, values: FloatArray | None = None) -> Self:
        """Make the model from the files that travel in an FMU."""

    @abstractmethod
    def initialize(self, t: float = 0.0) -> None:
        """Take over the parameters, go to the start state and compute the outputs there.

        May be called again before the first step, when a parameter has changed.

        Args:
            t: Time at the start, in [s].
        """

    @abstractmethod
    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h with the inputs as they stand.

        Args:
            t: Time at the beginning of the step, in [s].
            h: Length of the step, in [s].
        """

    @abstractmethod
    def get_state(self) -> bytes:
        """Everything that the model remembers beyond `values`, as plain bytes."""

    @abstractmethod
    def set_state(self, state: bytes) -> None:
        """Go back to a state from `get_state`; refuses bytes of another length."""

    def reset(self) -> None:
        """Back to the start values; `initialize` is due next."""
        self.values[:] = self._start

    def close(self) -> None:  # noqa: B027 - there mostly is nothing to do
        """Give back what is held beyond this process; for most models that is nothing.

        An FMU's model is closed when its host terminates the simulation. A second time does
        nothing, outputs stay, and `reset` leads back to the beginning.
        """

    def set_states(self, states: FloatArray) -> None:
        """Go to other states without any time passing.

        Args:
            states: One for each of `self.states`.

        Raises:
            SimulationError: The model names states and does not say how to go to them.
        """
        raise SimulationError(f"{type(self).__name__} names states and has no set_states()")

    def directional_derivative(
        self, t: float, h: float, unknowns: Indices, knowns: Indices, seeds: FloatArray
    ) -> FloatArray:
        """Derivative of the outputs after a step with respect to knowns at its beginning.

        See `derivatives` for the arguments, the scheme, and what may be a known.

        Raises:
            InputError: The model has no derivatives, or a known is none.
        """
        if not self.has_derivatives:
            raise InputError("this FMU has no directional derivatives")
        return directional_derivative(self, t, h, unknowns, knowns, seeds)
