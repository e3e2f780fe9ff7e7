"""Linear programs solved by HiGHS, and feasibility of a torque within the force limits."""

from __future__ import annotations

from typing import Any

import numpy as np

from controllers.arrays import FloatArray

# Torques are scaled to about 1, so that tolerances below the HiGHS default of 1e-7 are useful.
_OPTIONS: Any = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}

_ZERO_ROW = 1e-12  # rows are zero below this value, relative to the largest row
_MAX_ERROR = 1e-8  # largest torque error of a feasible torque, relative to the size of its terms


def linear_program(cost: FloatArray, low: FloatArray, high: FloatArray, **constraints: Any) -> Any:
    """Return the answer of `scipy.optimize.linprog`, whose other arguments are the constraints."""
    from scipy.optimize import linprog  # slow to import

    bounds = list(zip(low.tolist(), high.tolist(), strict=True))
    return linprog(cost, bounds=bounds, options=_OPTIONS, **constraints)


def solve_linear(
    cost: FloatArray,
    A: FloatArray,
    b: FloatArray,
    low: FloatArray,
    high: FloatArray,
    A_ub: FloatArray | None = None,
    b_ub: FloatArray | None = None,
) -> FloatArray | None:
    """Solve min cost'x s.t. A x = b, A_ub x <= b_ub, low <= x <= high; None if infeasible.

    The rows of A are scaled by their largest entries, so that the tolerance is equal for all rows.

    Args:
        cost: Cost vector, shape (k,).
        A: Equality matrix, shape (rows, k).
        b: Right-hand side of the equalities, shape (rows,).
        low: Lower bounds, shape (k,).
        high: Upper bounds, shape (k,).
        A_ub: Inequality matrix, shape (inequalities, k), or None.
        b_ub: Right-hand side of the inequalities, shape (inequalities,), or None.
    """
    size = np.abs(A).max(axis=1)
    size = np.where(size > _ZERO_ROW * size.max(initial=0.0), size, 1.0)
    equal = {"A_eq": A / size[:, None], "b_eq": b / size}
    answer = linear_program(cost, low, high, A_ub=A_ub, b_ub=b_ub, **equal)
    return np.asarray(answer.x) if answer.status == 0 else None


def is_infeasible(A: FloatArray, tau: FloatArray, f_min: FloatArray, f_max: FloatArray) -> bool:
    """Return whether no f within the force limits satisfies A f = tau, up to rounding.

    The function computes the smallest t >= 0 with |A f - tau| <= t, relative to the size of each
    row.

    Args:
        A: -L', shape (n, m).
        tau: Desired torque, shape (n,), in [N·m] or [N].
        f_min: Lower limits, shape (m,), in [N].
        f_max: Upper limits, shape (m,), in [N]; may be infinite.
    """
    m = A.shape[1]
    size = np.abs(A).max(axis=1)
    zero = size <= _ZERO_ROW * size.max(initial=0.0)
    scale = max(float(np.abs(tau).max()), float((np.abs(A) @ f_min).max()))
    if (np.abs(tau[zero]) > _MAX_ERROR * scale).any():
        return True
    rows, desired = A[~zero] / size[~zero, None], tau[~zero] / size[~zero]
    unit = max(float(np.abs(desired).max(initial=0.0)), float(f_min.max(initial=0.0)), 1e-300)
    answer = linear_program(
        np.append(np.zeros(m), 1.0),
        np.append(f_min, 0.0) / unit,
        np.append(f_max, np.inf) / unit,
        A_ub=np.vstack([np.c_[rows, -np.ones(len(rows))], np.c_[-rows, -np.ones(len(rows))]]),
        b_ub=np.append(desired, -desired) / unit,
    )
    return not (answer.status == 0 and float(np.asarray(answer.x)[-1]) <= _MAX_ERROR)
