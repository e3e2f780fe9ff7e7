"""Feedback gains along an optimal motion, from Riccati's recursion and equation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, solve_discrete_are

from controllers.arrays import FloatArray

from .problem import Iterate, OptimalProblem

_UNKNOWN: FloatArray = np.zeros(0)
_MIN_WEIGHT = 1e-6  # of a control, relative to the mean


class Stage(NamedTuple):
    """Linearised interval, x' = A x + B u, with the cost x'Q x + u'diag(R)u.

    Attributes:
        A, B: Derivatives of the end, shapes (nx, nx), (nx, nu).
        Q: Weight of the states, shape (nx, nx).
        R: Weights of the controls, shape (nu,).
        x: State at its start, shape (nx,); empty if it is unknown.
    """

    A: FloatArray
    B: FloatArray
    Q: FloatArray
    R: FloatArray
    x: FloatArray = _UNKNOWN


def riccati_step(stage: Stage, P: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the gain K of an interval, u = -K x, and the weight of the states at its start.

    Args:
        stage: The interval.
        P: Weight of the states at its end, shape (nx, nx).
    """
    A, B, BP = stage.A, stage.B, stage.B.T @ P
    K = np.asarray(np.linalg.solve(np.diag(stage.R) + BP @ B, BP @ A))
    start = np.asarray(stage.Q + A.T @ P @ (A - B @ K), dtype=np.float64)
    return K, 0.5 * (start + start.T)


def stationary_gain(stage: Stage) -> tuple[FloatArray, FloatArray] | None:
    """Return the gain and the weight of the states for infinitely many equal intervals.

    Returns:
        The gain, shape (nu, nx), and the weight, shape (nx, nx); None if the controls do not
        stabilise the robot.
    """
    try:
        P = solve_discrete_are(stage.A, stage.B, stage.Q, np.diag(stage.R)).astype(np.float64)
    except (LinAlgError, ValueError):
        return None
    K, P = riccati_step(stage, P)
    is_stable = np.isfinite(K).all() and abs(np.linalg.eigvals(stage.A - stage.B @ K)).max() < 1.0
    return (K, P) if is_stable else None


def stages(
    problem: OptimalProblem, at: Iterate, deviations: FloatArray, parts: int = 1
) -> list[Stage]:
    """Return the linearised parts of the intervals of a motion, with the cost of its problem.

    The cost additionally contains tracking: a deviation of a state costs as much as the largest
    controls of the motion. The costs of rates and of the duration are not included.

    Args:
        problem: The problem.
        at: The motion.
        deviations: Deviation of each state that costs as much as the largest controls, shape (nx,);
            infinite for states without such a cost.
        parts: Number of equal parts of each interval.

    Returns:
        One stage per part; empty if a state diverged.
    """
    h = at.duration / problem.intervals / parts
    starts, u = at.x[:-1], at.u
    lengths = np.full(len(u), h)
    terms = problem.costs.terms(at.x, u, at.duration)
    size = np.maximum(abs(u).max(axis=0), 1e-9)
    R = 2.0 * h * (problem.costs.controls if problem.costs.controls.any() else size**-2)
    largest = float((R * size**2).mean())
    R = np.maximum(R, _MIN_WEIGHT * largest / size**2)
    nodes = (terms.xx[:, :, None] * np.eye(at.x.shape[1]) + terms.dense) / parts
    Q = nodes[:-1] + np.diag(largest / deviations**2)
    rows_of_parts = []
    for _ in range(parts):
        part = problem.dynamics.run(starts, u, lengths, True, at.parameters)
        if part is None:
            return []
        rows = zip(part.A, part.B, Q, starts, strict=True)
        rows_of_parts.append([Stage(A, B, cost, R, x) for A, B, cost, x in rows])
        starts = part.ends
    return [stage for interval in zip(*rows_of_parts, strict=True) for stage in interval]


def gains_along(stages: list[Stage], P: FloatArray) -> FloatArray:
    """Return the gains of all intervals, shape (N, nu, nx), u = u* - K (x - x*).

    Args:
        stages: The intervals.
        P: Weight of the states after the last interval, shape (nx, nx).
    """
    gains = []
    for stage in reversed(stages):
        K, P = riccati_step(stage, P)
        gains.append(K)
    return np.array(gains[::-1])
