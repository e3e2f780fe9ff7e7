"""Start and goals of an optimal motion: bounds of states, and constraints of task coordinates."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.experiment.config.key_path import EVERY_OTHER
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.goals import GoalSettings
from cardsflow_fmu.experiment.motion.settings import MotionTable
from cardsflow_fmu.experiment.settings.predictive import override
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.arrays import BoolArray
from controllers.optimal.node_costs import NodeCost, squares
from controllers.optimal.problem import NodeConstraint
from sim_dart.dynamics.core import CoreDynamics
from sim_dart.optimal.shooting import Shooting

from .loops import advances, dependent
from .muscles import require_order, state_ranges
from .tasks import StateRows, TaskRates, TaskRows

_NO_LIMIT = 1e6  # size of limits of positions that files use for none, in [rad] or [m]
_WHOLE = 1e-6  # deviation of a time from a node, relative to an interval


def state_bounds(
    experiment: Experiment, motion: MotionTable, dynamics: CoreDynamics, shooting: Shooting
) -> tuple[FloatArray, FloatArray]:
    """Return the bounds of the states at the nodes, shape (N + 1, nx)."""
    bounds = motion.bounds
    low, high = override(dynamics.q_min, bounds.q_min), override(dynamics.q_max, bounds.q_max)
    low[low <= -_NO_LIMIT], high[high >= _NO_LIMIT] = -np.inf, np.inf
    for k, name in enumerate(dynamics.coordinate_names):
        require_order(experiment, f"q_max.{name}", low[k], high[k])
    speed = override(np.full(shooting.n, np.inf), bounds.qd_max)
    weakest, strongest = state_ranges(shooting, dynamics)
    x_low = np.tile([*low, *-speed, *weakest], (motion.intervals + 1, 1))
    x_high = np.tile([*high, *speed, *strongest], (motion.intervals + 1, 1))
    return x_low, x_high


class Goals(NamedTuple):
    """Goals of a motion, in addition to bounds of states.

    Attributes:
        constraints: Constraints of task coordinates.
        costs: Costs of goals with a weight.
    """

    constraints: list[NodeConstraint]
    costs: list[NodeCost]


def free_start(
    experiment: Experiment, motion: MotionTable, dynamics: CoreDynamics, nx: int
) -> BoolArray:
    """Return the flags of the states whose start is free, shape (nx,).

    By default, the states of muscles are free if a position or velocity is free, since they depend
    on it. A periodic coordinate that advances starts at the position of [start].

    Raises:
        UnknownNameError: A coordinate does not exist; the message names the key.
    """
    names, start = dynamics.coordinate_names, motion.start
    flags = np.zeros(nx, dtype=bool)
    for row, key in enumerate(("free", "free_speeds")):
        for name in getattr(start, key):
            if name not in (*names, EVERY_OTHER):
                where = f"motion.start.{key}"
                raise UnknownNameError("coordinate", name, names, file=experiment.file, key=where)
            chosen = [name in (other, EVERY_OTHER) for other in names]
            flags[row * dynamics.n : (row + 1) * dynamics.n] |= chosen
    if start.y and not start.free:
        flags[: dynamics.n] = True
    if motion.periodic:
        advance = advances(experiment, motion)
        flags[: dynamics.n] |= advance == 0.0
        flags[dynamics.n : 2 * dynamics.n] |= ~np.isnan(advance)
    flags[2 * dynamics.n :] = flags.any() if start.free_states is None else start.free_states
    return flags


def fix_start(
    experiment: Experiment,
    motion: MotionTable,
    dynamics: CoreDynamics,
    start: FloatArray,
    x_low: FloatArray,
    x_high: FloatArray,
) -> list[NodeConstraint]:
    """Fix the states of the start in the bounds; return the constraint of task coordinates.

    Args:
        experiment: The experiment.
        motion: Its [motion].
        dynamics: The robot.
        start: States of [start], shape (nx,).
        x_low: Lower bounds, shape (N + 1, nx), which are changed.
        x_high: Upper bounds.

    Raises:
        InputError: The start violates a bound, or a coordinate does not exist.
    """
    names, fixed = dynamics.coordinate_names, ~free_start(experiment, motion, dynamics, len(start))
    keys = [f"start.{letter}.{name}" for letter in ("q", "qd") for name in names]
    for k, key in enumerate(keys):
        least, most, value = x_low[0, k], x_high[0, k], start[k]
        if fixed[k] and not least <= value <= most:
            problem = f"must be within the bounds {least:.6g} to {most:.6g} of the motion"
            raise InputError(f"{problem}, not {float(value)!r}", file=experiment.file, key=key)
    x_low[0, fixed] = x_high[0, fixed] = start[fixed]
    task_start = motion.start.y
    return [_task_goal("start.y", task_start, 0, dynamics, len(start))] if task_start else []


def fix_goals(
    experiment: Experiment,
    motion: MotionTable,
    dynamics: CoreDynamics,
    x_low: FloatArray,
    x_high: FloatArray,
) -> Goals:
    """Fix the states of the goals in the bounds; return the other goals."""
    goals, n, nx = Goals([], []), dynamics.n, x_low.shape[1]
    speeds = n + np.flatnonzero(~dependent(experiment, n))
    for k, goal in enumerate(motion.goals):
        key = f"motion.goals[{k}]"
        node, last = _nodes(experiment, motion, goal, key)
        is_end = node == motion.intervals and not goal.is_moving
        if goal.rest or goal.hold or (goal.rest is None and is_end):
            x_low[node : last + 1, speeds] = x_high[node : last + 1, speeds] = 0.0
        targets = np.array([*(goal.q or [np.nan] * n), *(goal.qd or [np.nan] * n)])
        indices = np.flatnonzero(~np.isnan(targets))
        for j in indices.tolist():
            value, low, high = float(targets[j]), x_low[node, j], x_high[node, j]
            if not low <= value <= high:
                problem = f"must be within the bounds {low:.6g} to {high:.6g}, not {value!r}"
                where = f"{key}.{'qd' if j >= n else 'q'}.{dynamics.coordinate_names[j % n]}"
                raise InputError(problem, file=experiment.file, key=where)
            if goal.weight is None:
                x_low[node, j] = x_high[node, j] = value
        tasks = [
            _task_goal(f"goals[{k}].y", goal.y, node, dynamics, nx),
            _task_goal(f"goals[{k}].yd", goal.yd, node, dynamics, nx, TaskRates),
        ]
        tasks = [task for task in tasks if task.rows]
        if goal.weight is None:
            goals.constraints.extend(tasks)
            continue
        pairs = [(task.evaluate, task.low) for task in tasks]
        if len(indices):
            pairs.append((StateRows(indices, nx), targets[indices]))
        for evaluate, target in pairs:
            weights, nodes = np.full(len(target), goal.weight), np.array([node])
            goals.costs.append(squares(nodes, False, evaluate, weights, target))
    return goals


def _task_goal(
    key: str,
    y: tuple[float, ...],
    node: int,
    dynamics: CoreDynamics,
    nx: int,
    kind: type[TaskRows] = TaskRows,
) -> NodeConstraint:
    """Return the constraint that some task coordinates, or their rates, are given at a node."""
    rows = np.flatnonzero(~np.isnan(y)) if y else np.empty(0, dtype=int)
    target, names = np.array(y)[rows], tuple(dynamics.task_names[row] for row in rows)
    return NodeConstraint(key, names, np.array([node]), kind(dynamics, rows, nx), target, target)


def _nodes(
    experiment: Experiment, motion: MotionTable, goal: GoalSettings, key: str
) -> tuple[int, int]:
    """Return the node of a goal, and the last node at which it is held."""
    N, hold_nodes = motion.intervals, 0
    h = motion.duration[1] / N
    if goal.hold is not None:
        hold_nodes = _whole(experiment, goal.hold / h, f"{goal.hold!r} s", h, f"{key}.hold")
    if goal.fraction is not None:
        node = _whole(experiment, goal.fraction * N, f"{goal.fraction!r}", 1 / N, f"{key}.fraction")
    elif goal.time is not None:
        node = _whole(experiment, goal.time / h, f"{goal.time!r} s", h, f"{key}.time")
    else:
        node = N - hold_nodes
    if node + hold_nodes > N:
        problem = f"must end within the duration, {motion.duration[1]!r} s"
        raise InputError(problem, file=experiment.file, key=f"{key}.hold")
    return node, node + hold_nodes


def _whole(experiment: Experiment, at: float, value: str, unit: float, key: str) -> int:
    """Return a number of intervals, which must be whole."""
    node = round(at)
    if abs(at - node) > _WHOLE or not node:
        interval = f"{unit:.6g}{' s' * value.endswith('s')}"
        problem = f"must be a multiple of an interval, {interval}, above 0, not {value}"
        advice = "change motion.intervals" if at else "motion.start determines the start"
        raise InputError(f"{problem}; {advice}", file=experiment.file, key=key)
    return node
