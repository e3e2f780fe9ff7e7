"""The base of models that are made of an experiment."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import Self

from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.signals.ports import Port
from cardsflow_fmu.utils.arrays import FloatArray

from .model import FmuModel


class ExperimentModel(FmuModel):
    """A model that is made of an experiment.

    Args:
        experiment: What to simulate.
        values: Memory for the variables; allocated when None.
    """

    def __init__(self, experiment: Experiment, values: FloatArray | None = None) -> None:
        super().__init__(self.table(experiment), values)

    @staticmethod
    @abstractmethod
    def table(experiment: Experiment) -> list[Port]:
        """The table of variables for an experiment, without making the model."""

    @classmethod
    def from_resources(cls, folder: Path, values: FloatArray | None = None) -> Self:
        """Make the model from the files that travel in an FMU."""
        return cls(Experiment.from_resources(folder), values)
