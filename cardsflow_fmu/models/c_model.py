"""Base class of models that compute in C."""

from __future__ import annotations

from abc import abstractmethod
from typing import Protocol

from cardsflow_fmu.cosim.participant import CStep
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray

from .experiment_model import ExperimentModel
from .native.opened_model import OpenedModel


class Opened(Protocol):
    """Interface of an opened model, which is implemented in C or with DART."""

    def initialize(self, t: float) -> None: ...  # noqa: D102
    def step(self, t: float, h: float) -> None: ...  # noqa: D102
    def get_state(self) -> bytes: ...  # noqa: D102
    def set_state(self, state: bytes) -> None: ...  # noqa: D102


class CModel(ExperimentModel):
    """Model that is implemented in C, in `runtime/csrc/native`.

    Attributes:
        opened: The model in C, which reads and writes `values`.
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
        """Return the contents of the file `native.bin` of the model."""

    @classmethod
    def missing(cls, experiment: Experiment) -> str | None:
        """Return a requirement of the experiment that C does not support, or None."""
        return None

    @property
    def c_step(self) -> CStep | None:
        """Step of the model without Python; None if Python computes a part of it."""
        if type(self).step is CModel.step and isinstance(self.opened, OpenedModel):
            return self.opened.c_step
        return None

    def initialize(self, t: float = 0.0) -> None:
        """Read the parameters and set the start state."""
        self.opened.initialize(t)

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h with the current inputs."""
        self.opened.step(t, h)

    def get_state(self) -> bytes:
        """Return the state of the model that is not in `values`."""
        return self.opened.get_state()

    def set_state(self, state: bytes) -> None:
        """Restore a state from `get_state`."""
        self.opened.set_state(state)
