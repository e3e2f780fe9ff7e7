"""Linear programmes by HiGHS, and the feasibility of a torque within the bounds of forces."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import linprog

from controllers.arrays import FloatArray

# The default of HiGHS is 1e-7; torques are scaled to about 1.
_OPTIONS: Any = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}

_FLAT = 1e-12  # a row this small, relative to the largest, acts on nothing
_MISSED = 1e-8  # a torque error above this, relative to the size of the terms, is an error


def solve_linear(
    cost: FloatArray,
    A: FloatArray,
    b: FloatArray,
    low: FloatArray,
    high: FloatArray,
    A_ub: FloatArray | None = None,
    b_ub: FloatArray | None = None,
) -> FloatArray | None:
    """Solve min cost'x s.t. A x = b, A_ub x <= b_ub, low <= x <= high; None if there is no x.

    The rows of A are scaled by their largest entry, so that a tolerance means the same for all.

    Args:
        cost: Shape (k,).
        A: Shape (rows, k).
        b: Shape (rows,).
        low: Shape (k,).
        high: Shape (k,).
        A_ub: Shape (more rows, k).
        b_ub: Shape (more rows,).
    """
    size = np.abs(A).max(axis=1)
    size = np.where(size > _FLAT * size.max(initial=0.0), size, 1.0)
    answer = linprog(
        cost,
        A_ub=A_ub,
        b_ub=b_ub,
        A_eq=A / size[:, None],
        b_eq=b / size,
        bounds=_pairs(low, high),
        options=_OPTIONS,
    )
    return np.asarray(answer.x) if answer.status == 0 else None


def is_infeasible(A: FloatArray, tau: FloatArray, f_min: FloatArray, f_max: FloatArray) -> bool:
    """Return whether no f within the bounds makes A f = tau, up to rounding.

    It finds the smallest t >= 0 with |A f - tau| <= t, each row relative to its size.

    Args:
        A: -L', shape (n, m).
        tau: Shape (n,), in [N·m] or [N].
        f_min: Shape (m,), in [N].
        f_max: Shape (m,), in [N]; may be infinite.
    """
    m = A.shape[1]
    size = np.abs(A).max(axis=1)
    flat = size <= _FLAT * size.max(initial=0.0)
    scale = max(float(np.abs(tau).max()), float((np.abs(A) @ f_min).max()))
    if (np.abs(tau[flat]) > _MISSED * scale).any():
        return True
    rows, desired = A[~flat] / size[~flat, None], tau[~flat] / size[~flat]
    unit = max(float(np.abs(desired).max(initial=0.0)), float(f_min.max(initial=0.0)), 1e-300)
    answer = linprog(
        np.append(np.zeros(m), 1.0),
        A_ub=np.vstack([np.c_[rows, -np.ones(len(rows))], np.c_[-rows, -np.ones(len(rows))]]),
        b_ub=np.append(desired, -desired) / unit,
        bounds=_pairs(np.append(f_min, 0.0) / unit, np.append(f_max, np.inf) / unit),
        options=_OPTIONS,
    )
    return not (answer.status == 0 and float(np.asarray(answer.x)[-1]) <= _MISSED)


def _pairs(low: FloatArray, high: FloatArray) -> list[tuple[float, float]]:
    """Bounds as scipy takes them."""
    return list(zip(low.tolist(), high.tolist(), strict=True))
