"""Relaxed quadratic programs, with the smallest violation of infeasible constraints."""

from __future__ import annotations

import numpy as np
from scipy.sparse import block_diag, csc_matrix, csr_matrix, hstack, identity, vstack

from controllers.arrays import BoolArray

from .qp import QpSolution, QpSolver, QuadraticProgram

_DAMPING = 1e-6


def solve_relaxed(
    qp: QuadraticProgram, hard_rows: int, soft_bounds: BoolArray, weight: float
) -> QpSolution:
    """Solve a program in which constraints may be violated at a cost.

    Args:
        qp: The program.
        hard_rows: Number of equalities, from the first one, that must be satisfied.
        soft_bounds: Flags of the variables whose bounds may be violated, shape (n,).
        weight: Cost of a violation by 1.

    Returns:
        The solution of the variables of the program.
    """
    n, equal, unequal = len(qp.g), len(qp.b) - hard_rows, len(qp.low)
    bounded = np.flatnonzero(soft_bounds & (np.isfinite(qp.lb) | np.isfinite(qp.ub)))
    rows = unequal + len(bounded)
    places = hard_rows + np.arange(equal), np.arange(equal)
    select = csc_matrix((np.ones(equal), places), shape=(len(qp.b), equal))
    bounds = csr_matrix(identity(n))[bounded]
    A = csc_matrix(hstack([qp.A, select, -select, csc_matrix((len(qp.b), 2 * rows))]))
    C = [vstack([qp.C, bounds]), csc_matrix((rows, 2 * equal)), identity(rows), -identity(rows)]
    extra = 2 * (equal + rows)
    lb, ub = qp.lb.copy(), qp.ub.copy()
    lb[bounded], ub[bounded] = -np.inf, np.inf
    relaxed = QuadraticProgram(
        csc_matrix(block_diag([qp.P, _DAMPING * identity(extra)])),
        np.concatenate([qp.g, np.full(extra, weight)]),
        A,
        qp.b,
        csc_matrix(hstack(C)),
        np.concatenate([qp.low, qp.lb[bounded]]),
        np.concatenate([qp.high, qp.ub[bounded]]),
        np.concatenate([lb, np.zeros(extra)]),
        np.concatenate([ub, np.full(extra, np.inf)]),
    )
    solution = QpSolver(in_stages=False).solve(relaxed)
    return QpSolution(solution.d[:n], solution.y, solution.is_solved)
