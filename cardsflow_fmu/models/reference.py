"""The reference as an FMU model: desired positions, velocities and accelerations out."""

from __future__ import annotations

import struct

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.model.trajectory import Trajectory
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.signals.dependencies import Dependencies, reference_dependencies
from cardsflow_fmu.signals.groups import Groups
from cardsflow_fmu.signals.ports import reference_groups
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import SplineReference
from controllers.references.flower import (
    ApproachReference,
    FlowerReference,
    Reference,
    SequenceReference,
)

from .experiment_model import ExperimentModel

_TIME = struct.Struct("<d")


def make_reference(experiment: Experiment) -> Reference:
    """The reference of an experiment, its approach included."""
    settings = experiment.reference
    curve: Reference
    if isinstance(settings.curve, Trajectory):
        curve = SplineReference(settings.curve)
    else:
        flower = settings.curve
        curve = FlowerReference(
            flower.centre, flower.axes, flower.radius, flower.duration, flower.petals
        )
    if settings.approach is None:
        return curve
    approach = settings.approach
    lead = ApproachReference(approach.start, curve.evaluate(0.0).q, approach.duration)
    return SequenceReference([lead, curve])


class ReferenceModel(ExperimentModel):
    """The reference, evaluated at the end of every step, and loads from outside."""

    description = "Reference"
    any_step = True

    def __init__(self, experiment: Experiment, values: FloatArray | None = None) -> None:
        super().__init__(experiment, values)
        self._reference = make_reference(experiment)
        self._rows = self.views["reference"].reshape(3, -1)
        self._loads = self.views["loads"]
        self._disturbance = experiment.disturbance
        self._time = 0.0

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """The variables for an experiment in named groups."""
        space, disturbance = experiment.reference.space, experiment.disturbance
        return reference_groups(experiment.robot, space, with_loads=disturbance is not None)

    @classmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """What the outputs depend on, without making the model."""
        return reference_dependencies(cls.groups(experiment))

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
        disturbance = self._disturbance
        if disturbance is not None:
            acts = disturbance.begin <= time < disturbance.end
            self._loads[:] = np.ravel(disturbance.forces) if acts else 0.0
