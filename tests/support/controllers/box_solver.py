"""Quadratic programs with a diagonal cost, equalities that may be soft, and bounds.

min 1/2 x'Hx + g'x + 1/2 sum_j s_j²/eps_j   s.t.   A x - s = b,   lb <= x <= ub

with H diagonal and positive. A row with eps_j = 0 is hard: its slack s_j is zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from controllers.arrays import FloatArray
from controllers.qp.dual_newton import DualNewton, library

STATUSES = ("solved", "infeasible", "not converged", "wrong cost", "wrong bounds", "wrong rows")
"""Statuses by their number in C."""

_MIN_ROW = 1e-8  # size of a row whose terms are all small, relative to the largest row


@dataclass(frozen=True, eq=False)
class BoxProblem:
    """QP with a diagonal cost, hard or soft equalities, and bounds.

    Attributes:
        H_diagonal: Diagonal of H, shape (n,).
        g: Linear cost, shape (n,).
        A: Equality matrix, shape (m_eq, n).
        b: Right-hand side of the equalities, shape (m_eq,).
        lb, ub: Bounds, shape (n,); infinite if unlimited, equal for a fixed variable.
        softness: The eps of the rows, shape (m_eq,); None if all rows are hard.
    """

    H_diagonal: FloatArray
    g: FloatArray
    A: FloatArray
    b: FloatArray
    lb: FloatArray
    ub: FloatArray
    softness: FloatArray | None = None


class Residuals(NamedTuple):
    """Residuals of the optimality conditions, relative to the size of their terms.

    Attributes:
        equality: Largest |A x - s - b| of a row, relative to |b_j| + |s_j| + sum_i |A_ji x_i|.
        dual: Largest |x - clip(H⁻¹ (A'y - g), lb, ub)| of a variable, relative to |x_i| and the
            terms before clipping.
    """

    equality: float
    dual: float


class BoxSolution(NamedTuple):
    """Solution of a `BoxProblem`.

    Attributes:
        x: Variables, shape (n,).
        multipliers: y, shape (m_eq,), with Hx + g - A'y = 0 for variables not at a bound, and
            s_j = -eps_j y_j for soft rows. If `infeasible`, y is the certificate: a direction with
            y'b > y'Ax for every x within the bounds.
        status: One of `STATUSES`.
        slack: A x - b, shape (m_eq,).
        iterations: Newton steps.
        residuals: Residuals according to the solver.
    """

    x: FloatArray
    multipliers: FloatArray
    status: str
    slack: FloatArray
    iterations: int
    residuals: Residuals


class BoxSolver(DualNewton):
    """Solver for a sequence of problems of a fixed size, which starts from the last multipliers."""

    def answer(self, problem: BoxProblem) -> BoxSolution:
        """Solve a problem and return copies of the results."""
        for name in ("H_diagonal", "g", "A", "b", "lb", "ub"):
            getattr(self, name)[...] = getattr(problem, name)
        self.softness[:] = 0.0 if problem.softness is None else problem.softness
        status = STATUSES[self.solve()]
        steps = library().dual_newton_steps(self._handle)
        return BoxSolution(
            *(self.x.copy(), self.multipliers.copy(), status, self.slack.copy(), steps),
            Residuals(*self.residuals.tolist()),
        )

    def reset(self) -> None:
        """Start the next problem from zero."""
        self.start[:] = 0.0


def solve(problem: BoxProblem) -> BoxSolution:
    """Solve a problem by a new solver."""
    m_eq, n = problem.A.shape
    return BoxSolver(n, m_eq).answer(problem)


def residuals_of(problem: BoxProblem, x: FloatArray, y: FloatArray) -> Residuals:
    """Return the residuals of x and the multipliers y in the optimality conditions."""
    A, b, H, g = problem.A, problem.b, problem.H_diagonal, problem.g
    eps = 0.0 if problem.softness is None else problem.softness
    norms = np.sqrt((A * A / H).sum(axis=1))
    norms[norms == 0.0] = norms.max() or 1.0
    size = (np.abs(b) + np.abs(A) @ np.abs(x)) / norms
    size += _MIN_ROW * size.max()
    error = (A @ x - b + eps * y) / norms
    desired = np.clip((A.T @ y - g) / H, problem.lb, problem.ub)
    terms = np.abs(x) + (np.abs(g) + np.abs(A).T @ np.abs(y)) / H
    return Residuals(
        _relative(error, size + np.abs(eps * y) / norms), _relative(x - desired, terms)
    )


def _relative(error: FloatArray, size: FloatArray) -> float:
    """Return the largest |error| / size; 0/0 is defined as 0."""
    tiny = float(np.finfo(float).tiny)
    return float((np.abs(error) / np.maximum(size, tiny)).max(initial=0.0))
