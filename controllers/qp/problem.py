"""Quadratic programs with a diagonal cost, equalities that may be soft, and bounds.

min 1/2 x'Hx + g'x + 1/2 sum_j s_j²/eps_j   s.t.   A x - s = b,   lb <= x <= ub

with H diagonal and positive. A row with eps_j = 0 is hard: its slack s_j is zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray

Status = Literal["solved", "infeasible", "not converged"]

SOFTNESS = 1e-4

# Lower limit of the size of a row, relative to the largest row. It avoids large relative residuals
# of rows whose terms are all small.
_MIN_ROW = 1e-8


@dataclass(frozen=True, eq=False)
class BoxProblem:
    """QP with a diagonal cost, hard or soft equalities, and bounds.

    Units: with the cost in [c], x_i in [u_i] and row j in [r_j], H is in [c/u²], g in [c/u],
    A in [r/u], b and s in [r]. The solution depends on these units only by rounding.

    Attributes:
        H_diagonal: Diagonal of H, shape (n,), finite and positive.
        g: Linear cost, shape (n,).
        A: Equality matrix, shape (m_eq, n), in any memory layout; rows may be linearly dependent.
        b: Right-hand side of the equalities, shape (m_eq,).
        lb: Lower bounds, shape (n,); -inf if unlimited.
        ub: Upper bounds, shape (n,); inf if unlimited, equal to lb for a fixed variable.
        row_weights: Weights of the rows, shape (m_eq,), dimensionless: inf for a hard row, positive
            and finite for a soft row (default: all rows are hard).
        softness: The eps of a soft row with weight 1, relative to the scale of the problem: eps_j =
            softness · scale / row_weights_j, where scale is the mean of diag(A H⁻¹ A') over the
            soft rows. Rows with different units require different weights. The default changes a
            feasible solution by about 1e-4 relative to its size. Smaller values change it less.
    """

    H_diagonal: FloatArray
    g: FloatArray
    A: FloatArray
    b: FloatArray
    lb: FloatArray
    ub: FloatArray
    row_weights: FloatArray | None = None
    softness: float = SOFTNESS


@dataclass(frozen=True)
class Residuals:
    """Residuals of the optimality conditions, relative to the size of their terms.

    Attributes:
        equality: Largest |A x - s - b| of a row, relative to |b_j| + |s_j| + sum_i |A_ji x_i|.
        dual: Largest |x - clip(H⁻¹ (A'y - g), lb, ub)| of a variable, relative to |x_i| and the
            terms before clipping. NaN if the back end returns no multipliers.
        bounds: Largest violation of a bound.
    """

    equality: float
    dual: float
    bounds: float


@dataclass(frozen=True, eq=False)
class BoxSolution:
    """Solution of a `BoxProblem`. The arrays are copies.

    Attributes:
        x: Variables, shape (n,), always within the bounds; only valid if `solved`.
        multipliers: y, shape (m_eq,), with Hx + g - A'y = 0 for variables not at a bound, and
            s_j = -eps_j y_j for soft rows. If `infeasible`, y is the certificate: a direction with
            y'b > y'Ax for every x within the bounds.
        status: `solved` if the residuals passed the check; `infeasible` if a checked certificate
            proves that no x fulfils the hard rows; otherwise `not converged`.
        slack: A x - b, shape (m_eq,): the slack s_j of a soft row, or the rounding error of a hard
            row.
        iterations: Newton steps; 0 for other back ends.
        fell_back: Whether the chosen back end failed the check, so that `dual_newton` was used.
        solver: Name of the back end of this solution.
        residuals: Residuals of the check.
    """

    x: FloatArray
    multipliers: FloatArray
    status: Status
    slack: FloatArray
    iterations: int
    fell_back: bool
    solver: str
    residuals: Residuals


def row_softness(problem: BoxProblem) -> FloatArray:
    """Return the eps of every row, shape (m_eq,): 0 for hard rows.

    Raises:
        InputError: A weight or the softness is not positive.
    """
    rows = len(problem.b)
    if problem.row_weights is None:
        return np.zeros(rows)
    weights = np.asarray(problem.row_weights, dtype=np.float64)
    if weights.shape != (rows,):
        raise InputError(f"row_weights has shape {weights.shape}, not ({rows},)")
    if not (weights > 0).all():
        j = int(np.argmin(weights > 0))
        raise InputError(f"row_weights[{j}] {weights[j]} must be positive, inf for a hard row")
    if not 0 < problem.softness < np.inf:
        raise InputError(f"softness {problem.softness} must be finite and positive")
    soft = np.isfinite(weights)
    if not soft.any():
        return np.zeros(rows)
    A = np.asarray(problem.A, dtype=np.float64)[soft]
    scale = float(((A * A) @ (1.0 / np.asarray(problem.H_diagonal))).mean())
    eps: FloatArray = problem.softness * (scale or 1.0) / weights
    return eps


def check(problem: BoxProblem, eps: FloatArray, x: FloatArray, y: FloatArray | None) -> Residuals:
    """Compute the residuals of x and the multipliers y in the optimality conditions.

    Args:
        problem: The QP.
        eps: Softness of the rows, shape (m_eq,).
        x: Variables, shape (n,).
        y: Multipliers, shape (m_eq,), or None if unknown.
    """
    A, b, H, g = problem.A, problem.b, problem.H_diagonal, problem.g
    outside = float(max(np.maximum(problem.lb - x, x - problem.ub).max(), 0.0))
    norms = np.sqrt((A * A / H).sum(axis=1))
    norms[norms == 0.0] = norms.max() or 1.0
    error = (A @ x - b) / norms
    size = (np.abs(b) + np.abs(A) @ np.abs(x)) / norms
    size += _MIN_ROW * size.max()
    if y is None:
        hard = eps == 0
        return Residuals(_relative(error[hard], size[hard]), float("nan"), outside)
    desired = np.clip((A.T @ y - g) / H, problem.lb, problem.ub)
    terms = np.abs(x) + (np.abs(g) + np.abs(A).T @ np.abs(y)) / H
    return Residuals(
        _relative(error + eps * y / norms, size + np.abs(eps * y) / norms),
        _relative(x - desired, terms),
        outside,
    )


def _relative(error: FloatArray, size: FloatArray) -> float:
    """Return the largest |error| / size; 0/0 is defined as 0."""
    tiny = float(np.finfo(float).tiny)
    return float((np.abs(error) / np.maximum(size, tiny)).max(initial=0.0))
