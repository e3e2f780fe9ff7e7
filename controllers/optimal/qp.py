"""Sparse quadratic programs with the structure of an optimal-control problem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_matrix

from controllers.arrays import FloatArray

_TOLERANCE = 1e-9
_MAX_ITERATIONS = 60
_SMALL = 1e-6  # residuals after these iterations with which the solution is accepted


class QuadraticProgram(NamedTuple):
    """Minimise 1/2 d'P d + g'd subject to A d = b, low <= C d <= high, lb <= d <= ub.

    Attributes:
        P: Positive semidefinite, shape (n, n).
        g: Shape (n,).
        A: Equalities, shape (e, n).
        b: Shape (e,).
        C: Inequalities, shape (i, n).
        low, high: Shape (i,); may be infinite.
        lb, ub: Bounds, shape (n,); may be infinite.
    """

    P: csc_matrix
    g: FloatArray
    A: csc_matrix
    b: FloatArray
    C: csc_matrix
    low: FloatArray
    high: FloatArray
    lb: FloatArray
    ub: FloatArray

    def value(self, d: FloatArray) -> float:
        """Return the objective at d."""
        return float((self.g + 0.5 * (self.P @ d)) @ d)


@dataclass(frozen=True, slots=True)
class QpSolution:
    """Solution of a quadratic program.

    Attributes:
        d: The solution, shape (n,).
        y: Multipliers of the equalities, shape (e,).
        is_solved: Whether d is optimal; otherwise the program is infeasible or ill-conditioned.
    """

    d: FloatArray
    y: FloatArray
    is_solved: bool


class QpSolver:
    """PIQP for programs with the same places of nonzeros.

    Args:
        in_stages: Whether variables only occur together with those of adjacent stages in time,
            except some global ones at the end.
    """

    def __init__(self, in_stages: bool = True) -> None:
        import piqp  # late, since few commands need it

        self._solver, self._is_set_up = piqp.SparseSolver(), False
        self._solved, self._is_last = piqp.PIQP_SOLVED, piqp.PIQP_MAX_ITER_REACHED
        settings = self._solver.settings
        if in_stages:
            settings.kkt_solver = piqp.KKTSolver.sparse_multistage
        settings.eps_abs = settings.eps_rel = _TOLERANCE
        settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = _TOLERANCE
        settings.max_iter = _MAX_ITERATIONS

    def solve(self, qp: QuadraticProgram) -> QpSolution:
        """Solve a program."""
        set_data = self._solver.update if self._is_set_up else self._solver.setup
        some = qp.C.shape[0] > 0
        set_data(
            *(qp.P, qp.g, qp.A, qp.b),
            *((qp.C, qp.low, qp.high) if some else (None, None, None)),
            *(qp.lb, qp.ub),
        )
        self._is_set_up = True
        status, result = self._solver.solve(), self._solver.result
        is_accurate = max(result.info.primal_res, result.info.dual_res) <= _SMALL
        is_solved = status == self._solved or (status == self._is_last and is_accurate)
        return QpSolution(np.array(result.x), np.array(result.y), is_solved)
