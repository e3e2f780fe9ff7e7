"""Guesses of a motion: through the poses of its goals, and from the file of an earlier motion."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import InputError, limits
from cardsflow_fmu.cosim.signals.port import coordinate_signals
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.csv_table import read_csv
from controllers.analysis.inverse_dynamics import Motion
from controllers.optimal.problem import Iterate

from .feedback import control_signals
from .loops import closed_along
from .problem import MotionProblem

PARAMETER = "cardsflow.parameter_"
_SAME_TIME = 1e-9  # in [s]
_ROUNDING = 1e-9  # of the states of a robot at rest


def motion_from_start(setup: MotionProblem) -> Iterate:
    """Return the motion from the start with the controls of the rest.

    The robot moves if `start_command` does not hold it. If it rests or leaves the bounds, the guess
    is its rest.
    """
    problem, rest = setup.problem, setup.guess
    x, h = rest.x.copy(), np.array([rest.duration / problem.intervals])
    for k in range(problem.intervals):
        node = np.array([k])
        interval = setup.shooting.run(x[node], rest.u[node], h, False, nodes=node)
        if interval is None:
            return rest
        x[k + 1] = interval.ends[0]
    is_fixed = problem.x_low == problem.x_high
    is_inside = is_fixed | ((x >= problem.x_low) & (x <= problem.x_high))
    moves = abs(x - rest.x).max() > _ROUNDING
    return rest._replace(x=x) if moves and is_inside.all() else rest


def smooth_guess(setup: MotionProblem) -> Iterate:
    """Return a motion with minimum jerk between fixed positions, and the forces that drive it.

    A problem without fixed positions after the start has its rest as a guess.
    """
    problem, rest, n = setup.problem, setup.guess, setup.shooting.n
    fixed = problem.x_low == problem.x_high
    x, h = rest.x.copy(), rest.duration / problem.intervals
    for j in range(n):
        for a, b in pairwise(np.flatnonzero(fixed[:, j]).tolist()):
            start, end = problem.x_low[a, j], problem.x_low[b, j]
            x[a : b + 1, j] = start + (end - start) * _blend(np.linspace(0.0, 1.0, b - a + 1))
            x[b:, j] = end
    if np.array_equal(x, rest.x):
        return rest
    try:
        x[:, :n] = closed_along(setup.controls.dynamics, x[:, :n])
    except InputError:
        return rest
    x[:, n : 2 * n] = np.gradient(x[:, :n], h, axis=0)
    x[fixed] = problem.x_low[fixed]
    middle, rates = 0.5 * (x[1:] + x[:-1]), np.diff(x, axis=0) / h
    times = h * np.arange(0.5, problem.intervals)
    motion = Motion(times, middle[:, :n], middle[:, n : 2 * n], rates[:, n : 2 * n])
    u, states = setup.controls.along(motion)
    x[1:, 2 * n :] = states
    return rest._replace(x=x, u=u)


def _blend(s: FloatArray) -> FloatArray:
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))


def last_motion(file: Path, setup: MotionProblem) -> Iterate:
    """Return the motion in a file that `cardsflow optimise` wrote.

    States at the nodes are simulated from the row before each, and the controls are those at the
    centres of the intervals, so that the number of intervals can change. Free parameters that
    the file lacks are nominal.

    Raises:
        InputError: The file does not exist, or belongs to another robot or other controls.
    """
    if not file.is_file():
        raise InputError("does not exist; optimise without --resume first", file=file)
    names, rows = read_csv(file, kind="motion", most=limits.MOTION_VALUES)
    columns = dict(zip(names, rows.T, strict=True))
    robot, N = setup.dynamics.robot, setup.problem.intervals
    positions = coordinate_signals("q", robot)
    states = [*positions, *coordinate_signals("qd", robot), *setup.shooting.laws.state_names]
    controls = control_signals(setup)
    missing = [name for name in ("time", *states, *controls) if name not in columns]
    others = [name for name in names if name.startswith("q.") and name not in positions]
    if missing or others:
        problem = f"has no column {missing[0]!r}" if missing else f"has a column {others[0]!r}"
        problem += ", so it belongs to another robot or other [motion]; optimise without --resume"
        raise InputError(problem, file=file)
    times = columns["time"]
    table = np.array([columns[name] for name in (*states, *controls)])
    if len(times) < 2 or times[-1] <= times[0] or not np.isfinite(table).all():
        raise InputError("must have at least 2 rows of finite numbers", file=file)
    free = [name for name in names if name.startswith(PARAMETER)]
    p = np.array([columns[name][0] for name in free])
    if len(p) != len(setup.problem.parameters) or not np.isfinite(p).all():
        p = setup.problem.parameters.nominal
    rows, duration = table.T, float(times[-1] - times[0])
    nodes = times[0] + duration * np.arange(N + 1) / N
    near = np.searchsorted(times, nodes + _SAME_TIME, "right") - 1
    starts, u = np.split(rows[near], [len(states)], axis=1)
    parts = setup.shooting.run(starts, u, np.maximum(nodes - times[near], 0.0), False, p)
    centres = np.searchsorted(times, 0.5 * (nodes[1:] + nodes[:-1]), "right") - 1
    return Iterate(
        starts if parts is None else parts.ends, rows[centres, len(states) :], duration, p
    )
