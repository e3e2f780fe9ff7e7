"""Explanation why a motion does not satisfy its constraints."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.kinematics import inverse_kinematics
from controllers.arrays import BoolArray, IntArray
from controllers.optimal.problem import OptimalProblem, excess
from controllers.optimal.sqp import INFEASIBLE, Solution

from .feedback import control_signals
from .problem import MotionProblem

_AT_LIMIT = 1e-4  # distance from a limit, relative to its range
_MAX_NAMES = 3


def require_reachable(experiment: Experiment, setup: MotionProblem) -> None:
    """Check that a pose exists for the start and for every goal with all task coordinates.

    Raises:
        InputError: No pose within the joint limits reaches a goal; the message names the key.
    """
    assert experiment.motion is not None
    targets = {f"goals[{k}]": goal.y for k, goal in enumerate(experiment.motion.goals)}
    for name, y in {"start": experiment.motion.start.y, **targets}.items():
        if y and np.isfinite(y).all():
            try:
                inverse_kinematics(setup.dynamics, np.array(y), np.array(experiment.start.q))
            except InputError as error:
                error.file, error.key = experiment.file, f"motion.{name}.y"
                raise


def infeasibility(problem: OptimalProblem, solution: Solution) -> str:
    """Return the most violated constraint with its node, and the forces that are at a limit."""
    is_certain = solution.status == INFEASIBLE
    violation, node = _worst(problem, solution, with_gaps=not is_certain)
    T = solution.iterate.duration
    text = "no motion found: "
    if not is_certain:
        text += f"{solution.status} after {solution.history[-1].iteration} iterations; "
    time = node * T / problem.intervals
    text += f"{violation} at node {node:.4g} of {problem.intervals} (t = {time:.4g} s)"
    limited = _at_limits(problem, solution)
    if limited:
        text += f"; at their limits most of the time: {', '.join(limited)}"
    return f"{text}; use a longer duration, wider bounds or another goal"


def active_bounds(
    setup: MotionProblem, solution: Solution
) -> dict[str, tuple[FloatArray, BoolArray]]:
    """Return when the motion is at each bound by name, such as `f.biceps maximum`.

    Times in [s], and whether the motion is at the bound then. The longest ones are first, and
    those of muscles with their minimum force last. Fixed values, such as those of goals, are not
    included.
    """
    problem, at = setup.problem, solution.iterate
    by_name, N = dict[str, tuple[FloatArray, BoolArray]](), problem.intervals
    nodes = np.arange(N + 1)
    parts: list[tuple[Sequence[str], IntArray, FloatArray, FloatArray, FloatArray]] = [
        (control_signals(setup), nodes[:-1], at.u, problem.u_low, problem.u_high),
        (problem.state_names, nodes, at.x, problem.x_low, problem.x_high),
    ]
    for each, values in zip(problem.constraints, solution.linearisation.values, strict=False):
        if len(each.nodes) > 1 and each.shares is None:
            rows = [f"{each.name}.{row}" for row in each.rows]
            parts.append((rows, each.nodes, values, each.low, each.high))
    for names, places, values, low, high in parts:
        near = _AT_LIMIT * np.where(np.isfinite(high - low), high - low, 1.0)
        at_bounds = {"minimum": values <= low + near, "maximum": values >= high - near}
        for word, flags in at_bounds.items():
            pairs = zip(names, (flags & (low < high)).T, strict=True)
            times = np.asarray(places * (at.duration / N), dtype=float)
            by_name |= {f"{name} {word}": (times, is_at) for name, is_at in pairs if is_at.any()}
    idle = {name for name in by_name if name.startswith("f.") and name.endswith("minimum")}
    return dict(sorted(by_name.items(), key=lambda pair: (pair[0] in idle, -pair[1][1].mean())))


def _worst(problem: OptimalProblem, solution: Solution, *, with_gaps: bool) -> tuple[str, float]:
    """Return the largest violation of a bound of a state or of a constraint, and its node.

    A fraction of the node is the share of the interval after it.

    Args:
        problem: The problem.
        solution: The motion.
        with_gaps: Whether jumps of the states between intervals are included.
    """
    x, values_of = solution.iterate.x, solution.linearisation.values
    violations: list[tuple[float, str, float]] = []
    for linear, values in zip(problem.linear, values_of[len(problem.constraints) :], strict=True):
        miss = excess(values, linear.low, linear.high)
        at = int(miss.argmax())
        violation = f"{linear.name}.{linear.rows[at]} is missed by {miss[at]:.3g}"
        violations.append((float(miss[at]), violation, int(linear.nodes[at])))
    for constraint, values in zip(problem.constraints, values_of, strict=False):
        miss = excess(values, constraint.low, constraint.high)
        k, row = np.unravel_index(int(miss.argmax()), miss.shape)
        violation = f"{constraint.name}.{constraint.rows[row]} is missed by {miss[k, row]:.3g}"
        place = float(constraint.nodes[k])
        place += 0.0 if constraint.shares is None else float(constraint.shares[k])
        violations.append((float(miss[k, row]), violation, place))
    beyond = excess(x, problem.x_low, problem.x_high)
    k, row = np.unravel_index(int(beyond.argmax()), beyond.shape)
    low, high = problem.x_low[k, row], problem.x_high[k, row]
    bound = f"must be {low:.4g}" if low == high else f"must be from {low:.4g} to {high:.4g}"
    violation = f"{problem.state_names[row]} {bound}, but is {x[k, row]:.4g}"
    violations.append((float(beyond[k, row]), violation, int(k)))
    if with_gaps:
        gaps = abs(solution.linearisation.gaps)
        k, row = np.unravel_index(int(gaps.argmax()), gaps.shape)
        violation = f"{problem.state_names[row]} jumps by {gaps[k, row]:.3g}"
        violations.append((float(gaps[k, row]), violation, int(k) + 1))
    _, violation, node = max(violations)
    return violation, node


def _at_limits(problem: OptimalProblem, solution: Solution) -> list[str]:
    """Return the controls that are, or whose rates are, at a limit most of the time."""
    u, low, high = solution.iterate.u, problem.u_low, problem.u_high
    near = _AT_LIMIT * np.where(np.isfinite(high - low), high - low, 1.0)
    share = ((u >= high - near) | ((low < 0.0) & (u <= low + near))).mean(axis=0)
    order = np.argsort(-share)[:_MAX_NAMES]
    names = [problem.control_names[k] for k in order if share[k] > 0.5]
    values_of = solution.linearisation.values[len(problem.constraints) :]
    for linear, values in zip(problem.linear, values_of, strict=True):
        if linear.name == "f_rate_max":
            at = values >= linear.high - _AT_LIMIT * solution.iterate.duration
            counts = Counter(name for name, is_at in zip(linear.rows, at, strict=True) if is_at)
            often = [name for name, count in counts.items() if 2 * count > problem.intervals - 1]
            names += [f"rate of {name}" for name in often[:_MAX_NAMES]]
    return names
