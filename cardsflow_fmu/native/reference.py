"""Settings of native references, in the order of native_reference.c."""

from __future__ import annotations

import math
from collections.abc import Sequence

from numpy.typing import ArrayLike

from addin_sdfusion.robot.model.trajectory import Trajectory
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.reference import ApproachSettings, FlowerSettings
from cardsflow_fmu.models.reference import make_reference
from controllers import SplineReference

_SPLINES, _ROSE, _APPROACH = range(3)


def reference_settings(experiment: Experiment) -> list[ArrayLike]:
    """What is to be followed, and the forces from outside, as numbers."""
    settings, rows = experiment.reference, len(make_reference(experiment).evaluate(0.0).q)
    parts: list[ArrayLike] = []
    begin, count = 0.0, 1
    if settings.approach is not None:
        goal = _curve_start(experiment)
        parts += [0.0, *_approach(settings.approach, goal)]
        begin, count = settings.approach.duration, 2
    curve = settings.curve
    own = _splines(curve) if isinstance(curve, Trajectory) else _rose(curve)
    return [rows, *_disturbance(experiment), count, *parts, begin, *own]


def _curve_start(experiment: Experiment) -> list[float]:
    approach = experiment.reference.approach
    assert approach is not None
    goal: list[float] = make_reference(experiment).evaluate(approach.duration).q.tolist()
    return goal


def _disturbance(experiment: Experiment) -> list[ArrayLike]:
    """Number of loads, begin, end, the loads."""
    disturbance = experiment.disturbance
    if disturbance is None:
        return [0, 0.0, 0.0]
    forces = [value for force in disturbance.forces for value in force]
    return [len(forces), disturbance.begin, disturbance.end, forces]


def _approach(approach: ApproachSettings, goal: Sequence[float]) -> list[ArrayLike]:
    displacement = [b - a for a, b in zip(approach.start, goal, strict=True)]
    return [_APPROACH, approach.duration, approach.start, displacement]


def _rose(flower: FlowerSettings) -> list[ArrayLike]:
    last = math.pi * (1 if flower.petals % 2 else 2)
    numbers = [flower.radius, flower.petals, last]
    return [_ROSE, flower.duration, flower.centre, *flower.axes, *numbers]


def _splines(trajectory: Trajectory) -> list[ArrayLike]:
    spline = SplineReference(trajectory)
    table = spline.coefficients
    ends = trajectory.points[0].q, trajectory.points[-1].q
    return [_SPLINES, spline.duration, *table.shape[:2], spline.times, table, *ends]
