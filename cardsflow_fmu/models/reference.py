"""The reference as an FMU model: desired positions, velocities and accelerations out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot.model.trajectory import Trajectory
from cardsflow_fmu.cosim.signals.dependencies import Dependencies, reference_dependencies
from cardsflow_fmu.cosim.signals.groups import Groups
from cardsflow_fmu.cosim.signals.ports import reference_groups
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.reference import ApproachSettings, FlowerSettings
from controllers import SplineReference
from controllers.references.flower import (
    ApproachReference,
    FlowerReference,
    Reference,
    SequenceReference,
)

from .c_model import CModel
from .native.fields import Counts, Fields, encode

_SPLINES, _ROSE, _APPROACH = range(3)


class ReferenceModel(CModel):
    """The reference, evaluated at the end of every step, and loads from outside."""

    description = "Reference"
    any_step = True

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """The variables for an experiment in named groups."""
        space, disturbance = experiment.reference.space, experiment.disturbance
        return reference_groups(experiment.robot, space, with_loads=disturbance is not None)

    @classmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """What the outputs depend on, without making the model."""
        return reference_dependencies(cls.groups(experiment))

    @classmethod
    def file(cls, experiment: Experiment) -> bytes:
        """The contents of the model's `native.bin`."""
        return encode("reference", b"", cls.groups(experiment), *_fields(experiment))


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


class _Part(NamedTuple):
    """A part of a reference, from its beginning on."""

    kind: int
    duration: float
    data: Sequence[ArrayLike]
    segments: int = 0
    powers: int = 0


def _fields(experiment: Experiment) -> tuple[Counts, Fields]:
    """What is followed, and the forces from outside; see `encode`."""
    settings, parts, begins = experiment.reference, [], [0.0]
    if settings.approach is not None:
        parts.append(_approach(settings.approach, _goal(experiment)))
        begins.append(settings.approach.duration)
    curve = settings.curve
    parts.append(_splines(curve) if isinstance(curve, Trajectory) else _rose(curve))
    data = np.concatenate([np.ravel(numbers) for part in parts for numbers in part.data])
    fields: Fields = {
        "part_begin": begins,
        "part_duration": [part.duration for part in parts],
        "part_kind": [part.kind for part in parts],
        "part_segments": [part.segments for part in parts],
        "part_powers": [part.powers for part in parts],
        "data": data,
    }
    return {"parts": len(parts), "numbers": data.size}, fields | _disturbance(experiment)


def _goal(experiment: Experiment) -> list[float]:
    """Where the approach ends: the beginning of the curve."""
    approach = experiment.reference.approach
    assert approach is not None
    goal: list[float] = make_reference(experiment).evaluate(approach.duration).q.tolist()
    return goal


def _disturbance(experiment: Experiment) -> Fields:
    disturbance = experiment.disturbance
    if disturbance is None:
        return {"load_begin": 0.0, "load_end": 0.0, "load_forces": []}
    return {
        "load_begin": disturbance.begin,
        "load_end": disturbance.end,
        "load_forces": list(chain.from_iterable(disturbance.forces)),
    }


def _approach(approach: ApproachSettings, goal: Sequence[float]) -> _Part:
    displacement = [b - a for a, b in zip(approach.start, goal, strict=True)]
    return _Part(_APPROACH, approach.duration, [approach.start, displacement])


def _rose(flower: FlowerSettings) -> _Part:
    last = math.pi * (1 if flower.petals % 2 else 2)
    numbers = [flower.radius, flower.petals, last]
    return _Part(_ROSE, flower.duration, [flower.centre, *flower.axes, numbers])


def _splines(trajectory: Trajectory) -> _Part:
    spline = SplineReference(trajectory)
    table = spline.coefficients
    ends = trajectory.points[0].q, trajectory.points[-1].q
    return _Part(_SPLINES, spline.duration, [spline.times, table, *ends], *table.shape[:2])
