"""Guess of a motion through the poses of its goals."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray
from controllers.optimal.problem import Iterate, OptimalProblem


def smooth_guess(problem: OptimalProblem, rest: Iterate, n: int) -> Iterate:
    """Return a guess whose coordinates move with minimum jerk between their fixed positions.

    Args:
        problem: The problem.
        rest: Rest at the start.
        n: Number of coordinates, which are the first states; their velocities follow.
    """
    fixed = problem.x_low == problem.x_high
    x, N = rest.x.copy(), problem.intervals
    for j in range(n):
        for a, b in pairwise(np.flatnonzero(fixed[:, j]).tolist()):
            start, end = problem.x_low[a, j], problem.x_low[b, j]
            x[a : b + 1, j] = start + (end - start) * _blend(np.linspace(0.0, 1.0, b - a + 1))
            x[b:, j] = end
    x[:, n : 2 * n] = np.gradient(x[:, :n], rest.duration / N, axis=0)
    x[fixed] = problem.x_low[fixed]
    return rest._replace(x=x)


def _blend(s: FloatArray) -> FloatArray:
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
