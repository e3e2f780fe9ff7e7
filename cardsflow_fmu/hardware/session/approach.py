"""Approach: motion from the measured positions of the hardware to the start of the reference."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.plant import StartSettings
from cardsflow_fmu.experiment.settings.reference import ApproachSettings
from sim_dart import MusclePaths

from .connect import measured_positions


def with_approach(experiment: Experiment) -> Experiment:
    """Return the experiment with an approach from the measured positions, if it specifies one.

    The duration of the run increases by the duration of the approach. An approach of the reference
    is replaced.
    """
    seconds = approach_time(experiment)
    if seconds is None:
        return experiment
    q = measured_positions(experiment)
    reference, run = experiment.reference, experiment.run
    before = reference.approach.duration if reference.approach else 0.0
    begin = q if reference.space == "joint" else _task_position(experiment, q)
    return replace(
        experiment,
        start=StartSettings(q=q, qd=(0.0,) * len(q)),
        reference=replace(reference, approach=ApproachSettings(duration=seconds, start=begin)),
        run=run.copy_with(duration=run.duration + seconds - before),
    )


def approach_time(experiment: Experiment) -> float | None:
    """Return the duration of the approach from the measured positions, in [s], or None.

    Raises:
        InputError: The reference is an external FMU, whose start cannot be changed.
    """
    seconds = experiment.hardware.approach
    if seconds is None or not experiment.hardware.use:
        return None
    if "reference" in experiment.fmus:
        problem = "is not supported with an external FMU as reference; remove this setting"
        raise InputError(problem, file=experiment.file, key="hardware.approach")
    return seconds


def _task_position(experiment: Experiment, q: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(MusclePaths(experiment.robot).task_position(np.array(q)).tolist())
