"""The base of models that are made of an experiment."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import Self

import numpy as np

from cardsflow_fmu.cosim.signals.dependencies import Dependencies
from cardsflow_fmu.cosim.signals.groups import Groups, all_ports, group_places, group_views
from cardsflow_fmu.cosim.signals.port import Port
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.runtime.derivatives import Indices
from cardsflow_fmu.runtime.model import FmuModel
from cardsflow_fmu.utils.arrays import FloatArray


class ExperimentModel(FmuModel):
    """A model that is made of an experiment.

    Args:
        experiment: What to simulate.
        values: Memory for the variables; allocated when None.

    Attributes:
        views: The values of each group.
    """

    def __init__(self, experiment: Experiment, values: FloatArray | None = None) -> None:
        groups = self.groups(experiment)
        super().__init__(all_ports(groups), values)
        self._places = group_places(groups)
        self.views = group_views(groups, self.values)

    def indices(self, *names: str) -> Indices:
        """Where the variables of some groups are in `values`."""
        every: Indices = np.arange(self.values.size, dtype=np.intp)
        return np.concatenate([every[self._places[name]] for name in names])

    @staticmethod
    @abstractmethod
    def groups(experiment: Experiment) -> Groups:
        """The variables for an experiment in named groups, without making the model."""

    @classmethod
    @abstractmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """What the outputs depend on, without making the model."""

    @classmethod
    def table(cls, experiment: Experiment) -> list[Port]:
        """The table of variables for an experiment, without making the model."""
        return all_ports(cls.groups(experiment))

    @classmethod
    def from_resources(cls, folder: Path, values: FloatArray | None = None) -> Self:
        """Make the model from the files that travel in an FMU."""
        return cls(Experiment.from_resources(folder), values)
