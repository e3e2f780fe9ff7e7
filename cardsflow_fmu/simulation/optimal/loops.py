"""Closed kinematic loops in optimal motions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.settings import MotionTable
from cardsflow_fmu.utils.arrays import BoolArray, FloatArray
from sim_dart.dynamics.core import CoreDynamics
from sim_dart.dynamics.independent import control_dynamics


def closing(experiment: Experiment, robot: Robot) -> CoreDynamics | None:
    """Return dynamics that close the loops of a robot; None without loops."""
    if not robot.loops:
        return None
    return control_dynamics(robot, experiment.controller.dependent, may_be_singular=True)


def dependent(experiment: Experiment, n: int) -> BoolArray:
    """Return the flags of the coordinates that follow from closed loops, shape (n,)."""
    flags = experiment.controller.dependent
    if not experiment.robot.loops or not flags:
        return np.zeros(n, dtype=bool)
    return np.array(flags, dtype=bool)


def require_independent(experiment: Experiment, motion: MotionTable, names: Sequence[str]) -> None:
    """Check that start and goals do not set coordinates that follow from closed loops.

    Raises:
        InputError: The message names the key.
    """
    flags = dependent(experiment, len(names))
    if not flags.any():
        return
    if motion.start.model_fields_set:
        problem = "does not support closed loops; use motion.periodic, or set [start]"
        raise InputError(problem, file=experiment.file, key="motion.start")
    for k, goal in enumerate(motion.goals):
        for letter, values in (("q", goal.q), ("qd", goal.qd)):
            for name, value, is_dependent in zip(names, values, flags, strict=bool(values)):
                if is_dependent and not np.isnan(value):
                    problem = "follows from the closed loops; omit it, or change controller"
                    key = f"motion.goals[{k}].{letter}.{name}"
                    raise InputError(f"{problem}.dependent", file=experiment.file, key=key)


def advances(experiment: Experiment, motion: MotionTable) -> FloatArray:
    """Return the advances of periodic coordinates, shape (n,); nan for the others.

    Coordinates that follow from closed loops return if they are not set.
    """
    advance = np.array(motion.periodic)
    flags = dependent(experiment, len(advance))
    return np.where(np.isnan(advance) & flags, 0.0, advance)


def closed_along(dynamics: CoreDynamics, q: FloatArray) -> FloatArray:
    """Return poses with closed loops, each near the pose before; q has shape (k, n).

    Raises:
        InputError: The loops cannot be closed.
    """
    closed = q.copy()
    for k in range(1, len(q)):
        closed[k, dynamics.dependent] = closed[k - 1, dynamics.dependent]
        closed[k] = dynamics.closed(closed[k])
    return closed


def constant_speed(
    advance: FloatArray, N: int, dynamics: CoreDynamics, q: FloatArray, duration: float
) -> FloatArray:
    """Return q and qd at the nodes of a periodic motion at constant speed, shape (N + 1, 2 n).

    Args:
        advance: Advances of the coordinates, shape (n,).
        N: Number of intervals.
        dynamics: The robot, with the loops of `closing`.
        q: Start, shape (n,).
        duration: Duration, in [s].
    """
    rows = q + np.linspace(0.0, 1.0, N + 1)[:, None] * advance
    if not dynamics.dependent.any():
        return np.hstack([rows, np.tile(advance / duration, (N + 1, 1))])
    rows = closed_along(dynamics, rows)
    wrapped = np.vstack([rows[-2] - advance, rows, rows[1] + advance])
    return np.hstack([rows, (wrapped[2:] - wrapped[:-2]) * (0.5 * N / duration)])
