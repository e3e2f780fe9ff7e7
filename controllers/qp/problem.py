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

# A row's terms below this share of the largest row's are not compared with themselves.
_MIN_ROW = 1e-8


@dataclass(frozen=True, eq=False)
class BoxProblem:
    """A QP with a diagonal cost, equalities that may be soft, and bounds.

    Units: with the cost in [c], x_i in [u_i] and row j in [r_j], H is in [c/u²], g in [c/u],
    A in [r/u], b and s in [r]. The answer does not depend on these units beyond rounding.

    Attributes:
        H_diagonal: Diagonal of H, shape (n,), finite and positive.
        g: Linear cost, shape (n,).
        A: Equalities, shape (m_eq, n), in any memory layout; rows may depend on each other.
        b: Their right sides, shape (m_eq,).
        lb: Lower bounds, shape (n,); -inf if there is none.
        ub: Upper bounds, shape (n,); inf if there is none, equal to lb for a fixed variable.
        row_weights: Shape (m_eq,), without unit: inf for a hard row, positive and finite for a soft
            one. All rows are hard when None.
        softness: The eps of a soft row of weight 1, relative to the problem's scale: eps_j =
            softness · scale / row_weights_j, where scale is the mean of diag(A H⁻¹ A') over the
            soft rows. Rows of different units need weights of their own. The default bends a
            solution that exists by about 1e-4 of itself; a smaller one bends it less.
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
    """Residuals of the optimality conditions, each relative to the terms that are added up.

    Attributes:
        equality: Largest |A x - s - b| of a row, relative to |b_j| + |s_j| + sum_i |A_ji x_i|.
        dual: Largest |x - clip(H⁻¹ (A'y - g), lb, ub)| of a variable, relative to |x_i| and the
            terms before clipping. NaN if the back end gave no multipliers.
        bounds: Largest violation of a bound.
    """

    equality: float
    dual: float
    bounds: float


@dataclass(frozen=True, eq=False)
class BoxSolution:
    """An answer to a `BoxProblem`; the arrays are the caller's own.

    Attributes:
        x: Shape (n,), always within the bounds. Without meaning unless `solved`.
        multipliers: y, shape (m_eq,), with Hx + g - A'y = 0 for variables off their bounds, and
            s_j = -eps_j y_j for soft rows. If `infeasible`, the certificate: a direction y with
            y'b > y'Ax for every x within the bounds.
        status: `solved`: the residuals were checked. `infeasible`: no x fulfils the hard rows, and
            the certificate was checked. `not converged`: neither could be shown.
        slack: A x - b, shape (m_eq,): of a soft row its slack s_j, of a hard one what rounding
            leaves.
        iterations: Newton steps; 0 if another back end answered.
        fell_back: Whether the chosen back end gave no answer that passed the check.
        solver: Name of the back end that answered.
        residuals: What the check found.
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
    """How well x and the multipliers y fulfil the optimality conditions.

    Args:
        problem: The program.
        eps: Softness of the rows, shape (m_eq,).
        x: Shape (n,).
        y: Multipliers, shape (m_eq,); None if they are unknown.
    """
    A, b, H, g = problem.A, problem.b, problem.H_diagonal, problem.g
    outside = float(max(np.maximum(problem.lb - x, x - problem.ub).max(), 0.0))
    norms = np.sqrt((A * A / H).sum(axis=1))
    norms[norms == 0.0] = norms.max() or 1.0
    rest = (A @ x - b) / norms
    size = (np.abs(b) + np.abs(A) @ np.abs(x)) / norms
    size += _MIN_ROW * size.max()
    if y is None:
        hard = eps == 0
        return Residuals(_relative(rest[hard], size[hard]), float("nan"), outside)
    desired = np.clip((A.T @ y - g) / H, problem.lb, problem.ub)
    terms = np.abs(x) + (np.abs(g) + np.abs(A).T @ np.abs(y)) / H
    return Residuals(
        _relative(rest + eps * y / norms, size + np.abs(eps * y) / norms),
        _relative(x - desired, terms),
        outside,
    )


def _relative(rest: FloatArray, size: FloatArray) -> float:
    """Return the largest |rest| / size; 0/0 is defined as 0."""
    tiny = float(np.finfo(float).tiny)
    return float((np.abs(rest) / np.maximum(size, tiny)).max(initial=0.0))
