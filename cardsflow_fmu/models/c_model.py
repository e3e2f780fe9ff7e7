"""The base of models of an experiment that compute in C."""

from __future__ import annotations

from abc import abstractmethod
from typing import Protocol

from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray

from .experiment_model import ExperimentModel
from .native.opened_model import OpenedModel


class Opened(Protocol):
    """What computes a model: C, or DART in its place."""

    def initialize(self, t: float) -> None: ...  # noqa: D102
    def step(self, t: float, h: float) -> None: ...  # noqa: D102
    def get_state(self) -> bytes: ...  # noqa: D102
    def set_state(self, state: bytes) -> None: ...  # noqa: D102


class CModel(ExperimentModel):
    """A model whose formulas are in C, below `runtime/csrc/native`.

    Args:
        experiment: What to simulate.
        values: Memory for the variables; allocated when None.

    Attributes:
        opened: The model in C, on `values`.
    """

    opened: Opened

    def __init__(self, experiment: Experiment, values: FloatArray | None = None) -> None:
        super().__init__(experiment, values)
        self.opened = self._open(experiment)

    def _open(self, experiment: Experiment) -> Opened:
        return self._opened_in_c(experiment)

    def _opened_in_c(self, experiment: Experiment) -> OpenedModel:
        return OpenedModel(self.file(experiment), self.ports, self.values)

    @classmethod
    @abstractmethod
    def file(cls, experiment: Experiment) -> bytes:
        """The contents of the model's `native.bin`."""

    @classmethod
    def missing(cls, experiment: Experiment) -> str | None:
        """What the experiment needs and C does not have, in words; None where it has all."""
        return None

    def initialize(self, t: float = 0.0) -> None:
        """Take over the parameters and go to the start state."""
        self.opened.initialize(t)

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h with the inputs as they stand."""
        self.opened.step(t, h)

    def get_state(self) -> bytes:
        """Everything that the model remembers beyond `values`."""
        return self.opened.get_state()

    def set_state(self, state: bytes) -> None:
        """Go back to a state from `get_state`."""
        self.opened.set_state(state)
