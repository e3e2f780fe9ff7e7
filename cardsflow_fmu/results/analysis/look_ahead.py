"""Speeds at which the reference remains feasible after the loss of a muscle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu.cosim.signals.estimation import measured_muscles
from cardsflow_fmu.cosim.signals.reaction import DECISIONS
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.look_ahead import FALL, POSE, LookAhead
from cardsflow_fmu.experiment.settings.faults import FaultsTable
from cardsflow_fmu.utils.arrays import BoolArray, FloatArray
from controllers.analysis.failures import required_strength
from controllers.analysis.inverse_dynamics import Motion, MotionTerms

from .failures import force_limits, motion_points
from .sizing import actuator_terms, required_motion

SPEEDS = (1.0, 0.5, 0.25)
"""Speeds of the reference that are tested, relative to its nominal speed."""


def with_look_ahead(experiment: Experiment) -> Experiment:
    """Return the experiment with the table of its reaction to lost muscles, if it reacts."""
    if not experiment.reacts_to_faults or experiment.look_ahead is not None:
        return experiment
    return replace(experiment, look_ahead=look_ahead(experiment))


def look_ahead(experiment: Experiment) -> LookAhead:
    """Compute the table by the linear programs of `cardsflow faults`.

    Raises:
        InputError: The robot has no muscles, or cannot reach the reference.
    """
    robot, motion = required_motion(experiment, motion_points(experiment))
    terms = {speed: _terms(robot, motion, speed) for speed in (*SPEEDS, POSE)}
    names = terms[1.0][1].muscle_names
    muscles = [experiment.robot.muscles[k].name for k in measured_muscles(experiment.robot)]
    ramp = (experiment.faults or FaultsTable()).ramp
    speeds = {name: tuple(_speeds(terms, names.index(name), ramp)) for name in muscles}
    return LookAhead(times=tuple(motion.times.tolist()), speeds=speeds)


def worst_reactions(experiment: Experiment) -> dict[str, str]:
    """Return what happens in the worst case if each muscle breaks, and its share of the time.

    A robot falls if the other muscles cannot even hold its pose.
    """
    table = experiment.look_ahead or look_ahead(experiment)
    return {name: _worst_reaction(speeds) for name, speeds in table.speeds.items()}


def _worst_reaction(speeds: Sequence[float]) -> str:
    worst = min(speeds)
    share = speeds.count(worst) / len(speeds)
    return reaction_at(worst) + (f" ({share:.0%} of the time)" if share < 1.0 else "")


def reaction_at(speed: float) -> str:
    """Return the reaction for a speed of the table, such as `slow down to 50 %`."""
    if speed in (FALL, POSE):
        return "fall" if speed == FALL else DECISIONS[3]
    return DECISIONS[1] if speed == 1.0 else f"{DECISIONS[2]} to {speed:.0%}"


def _terms(robot: Robot, motion: Motion, speed: float) -> tuple[Robot, MotionTerms]:
    slower = replace(motion, qd=speed * motion.qd, qdd=speed**2 * motion.qdd)
    return actuator_terms(robot, slower)


def _speeds(terms: dict[float, tuple[Robot, MotionTerms]], failed: int, ramp: float) -> list[float]:
    """Return the speed at each point without a muscle."""
    times = terms[1.0][1].motion.times
    speeds = np.full(len(times), FALL)
    for speed in SPEEDS:
        is_feasible = _feasible(terms[speed], failed)
        lasting = np.logical_and.accumulate(is_feasible[::-1])[::-1]
        speeds[lasting & (speeds < 0)] = speed
        if (speeds > 0).all():
            return speeds.tolist()
    can_hold = _feasible(terms[POSE], failed)
    last = np.searchsorted(times, times + ramp / 2.0)  # where the reference stops
    for k in np.flatnonzero(speeds < 0):
        if can_hold[k : last[k] + 1].all():
            speeds[k] = POSE
    return speeds.tolist()


def _feasible(terms: tuple[Robot, MotionTerms], failed: int) -> BoolArray:
    robot, motion = terms
    strength: FloatArray = required_strength(motion, (failed,), force_limits(robot, motion))
    return np.asarray(strength <= 1.0)
