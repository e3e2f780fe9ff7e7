"""Base class of models of an experiment."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import Any, Self

import numpy as np

from cardsflow_fmu.cosim.signals.dependencies import Dependencies
from cardsflow_fmu.cosim.signals.groups import Groups, all_ports, group_slices
from cardsflow_fmu.cosim.signals.port import Port
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.runtime.model import FmuModel
from cardsflow_fmu.utils.arrays import FloatArray, IntArray


class ExperimentModel(FmuModel):
    """Model of an experiment. Models can be copied and pickled with their state, except hardware.

    Args:
        values: Memory for the variables (default: allocated).

    Attributes:
        places: Position of each group of variables in `values`.
        views: Values of each group of variables.
    """

    def __init__(self, experiment: Experiment, values: FloatArray | None = None) -> None:
        self._experiment = experiment
        groups = self.groups(experiment)
        super().__init__(all_ports(groups), values)
        self.places = group_slices(groups)
        self.views = {name: self.values[place] for name, place in self.places.items()}

    def __reduce__(self) -> tuple[Any, ...]:
        """Describe a copy by experiment, values and state, since pointers to C cannot be copied."""
        state = self.values.copy(), self.get_state()
        return _restored_model, (type(self), self._experiment, *state)

    def indices(self, *names: str) -> IntArray:
        """Return the indices of the variables of some groups in `values`."""
        indices: IntArray = np.arange(self.values.size, dtype=np.intp)
        return np.concatenate([indices[self.places[name]] for name in names])

    @staticmethod
    @abstractmethod
    def groups(experiment: Experiment) -> Groups:
        """Return the variables for an experiment in named groups, without creating the model."""

    @classmethod
    @abstractmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """Return the dependencies of the outputs without creating the model."""

    @classmethod
    def table(cls, experiment: Experiment) -> list[Port]:
        """Return the variables for an experiment, without creating the model."""
        return all_ports(cls.groups(experiment))

    @classmethod
    def from_resources(cls, folder: Path, values: FloatArray | None = None) -> Self:
        """Create the model from the resources of an FMU."""
        return cls(Experiment.from_resources(folder), values)


def _restored_model(
    cls: type[ExperimentModel], experiment: Experiment, values: FloatArray, state: bytes
) -> ExperimentModel:
    model = cls(experiment)
    model.values[:] = values
    model.initialize()
    model.set_state(state)
    model.values[:] = values
    return model
