"""The reference as an FMU model: desired positions, velocities and accelerations out."""

from __future__ import annotations

import struct

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment import Experiment
from cardsflow_fmu.ports import Port, reference_ports
from controllers import SplineReference

from .experiment_model import ExperimentModel
from .model import FloatArray

_TIME = struct.Struct("<d")


class ReferenceModel(ExperimentModel):
    """A spline through given joint positions, evaluated at the end of every step.

    Args:
        experiment: Whose reference.
        values: Memory for the variables.
    """

    description = "Joint-space reference"

    def __init__(self, experiment: Experiment, values: FloatArray | None = None) -> None:
        super().__init__(experiment, values)
        self._reference = SplineReference(experiment.trajectory)
        self._rows = self.outputs.reshape(3, -1)
        self._time = 0.0

    @staticmethod
    def table(experiment: Experiment) -> list[Port]:
        """The table of variables for an experiment."""
        return reference_ports(experiment.robot)

    def initialize(self, t: float = 0.0) -> None:
        """Go to the start time."""
        self._go(t)

    def step(self, t: float, h: float) -> None:
        """The reference at t + h."""
        self._go(t + h)

    def get_state(self) -> bytes:
        """The time."""
        return _TIME.pack(self._time)

    def set_state(self, state: bytes) -> None:
        """Go back to a state from `get_state`."""
        if len(state) != _TIME.size:
            raise InputError(f"a reference's state has {_TIME.size} bytes, not {len(state)}")
        self._go(_TIME.unpack(state)[0])

    def _go(self, time: float) -> None:
        self._time = time
        self._rows[:] = np.stack(self._reference.evaluate(time))
