"""Which muscles, motors and joints an experiment's sensors measure."""

from __future__ import annotations

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.estimator import EstimatorTable
from cardsflow_fmu.signals.estimation import measured_muscles

from .native.fields import Fields


def estimator_settings(experiment: Experiment) -> EstimatorTable:
    """[estimator] of an experiment.

    Raises:
        InputError: There is none.
    """
    if experiment.estimator is None:
        raise InputError("there is no [estimator] in the experiment", key="estimator")
    return experiment.estimator


def places(experiment: Experiment) -> Fields:
    """The muscle of each length and tension, and the coordinates of torques and encoders."""
    robot = experiment.robot
    return {
        "measured": measured_muscles(robot),
        "motors": [j for j, coordinate in enumerate(robot.coordinates) if coordinate.actuated],
        "encoded": estimator_settings(experiment).encoded,
    }
