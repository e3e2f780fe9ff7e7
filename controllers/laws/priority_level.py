"""The QP of the tasks down to a priority, of a controller in operational space."""

from __future__ import annotations

import numpy as np

from controllers.arrays import FloatArray
from controllers.qp.solver import BoxSolver


class PriorityLevel:
    """The QP of the tasks down to a priority: fixed parts, memory and solver.

    Attributes:
        tasks: Indices of the tasks of this priority.
        before: Indices of all tasks before.
        known: Indices of the ones before and of these, in the order of the rows.
        is_weighted: Whether all of its tasks have finite weights, and so may always give way.
    """

    def __init__(
        self,
        rank: float,
        ranks: FloatArray,
        W: FloatArray,
        H: FloatArray,
        n: int,
        solver: str,
    ) -> None:
        self.tasks = np.flatnonzero(ranks == rank)
        self.before = np.flatnonzero(ranks < rank)
        self.known = np.concatenate([self.before, self.tasks])
        self.rows = n + len(self.known)
        weighted = np.flatnonzero(np.isfinite(W[self.tasks]))
        self.is_weighted = len(weighted) == len(self.tasks)
        size = len(H) + len(weighted)
        self.H = np.concatenate([H, W[self.tasks][weighted]])
        self.A = np.zeros((self.rows, size))
        self.A[n + len(self.before) + weighted, len(H) + np.arange(len(weighted))] = 1.0
        self.b = np.zeros(self.rows)
        self.g = np.zeros(size)
        self.lb, self.ub = np.full(size, -np.inf), np.full(size, np.inf)
        self.soft_rows = np.full(self.rows, np.inf)
        self.soft_rows[n + len(self.before) :] = 1.0
        self.solver = BoxSolver(size, self.rows, solver)
