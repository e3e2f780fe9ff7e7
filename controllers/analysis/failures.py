"""Motions with failed muscles or motors: the strength that the others need.

    min s   subject to   -L(q)'f = tau,   f_min <= f <= s f_max,   f = 0 for failed actuators

The motion is feasible if s <= 1 at all points.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from addin_sdfusion.robot import SimulationError
from controllers.arrays import FloatArray
from controllers.force_distribution.feasibility import linear_program
from controllers.force_distribution.motor_columns import split_motors

from .inverse_dynamics import MotionTerms

_SMALL = 1e-12
_MAX_MISSING = 1e-8  # torque error of a feasible point, relative to the torques


def required_strength(
    terms: MotionTerms,
    failed: Sequence[int] = (),
    limits: tuple[FloatArray, FloatArray] | None = None,
) -> FloatArray:
    """Return the smallest factor of the force limits that suffices at each point of a motion.

    Args:
        terms: Torques and Jacobians of a actuators along the motion.
        failed: Indices of the actuators that produce no force.
        limits: Lower and upper force limits at each point, shape (T, a) each, in [N]
            (default: those of `terms`).

    Returns:
        s, shape (T,); infinite where no factor suffices.
    """
    low, high = limits or (terms.f_min, terms.f_max)
    L, low, high = _columns(terms, failed, low, high)
    size = np.maximum(np.abs(L).max(axis=1), _SMALL)  # of each row, for the tolerances
    A, b = -np.swapaxes(L, 1, 2) / size[:, :, None], terms.tau / size
    missing = _missing_torque(A, b, low)
    least = np.einsum("kij,kj->ki", A, low)
    scale = np.maximum(np.abs(b).max(axis=1), np.abs(least).max(axis=1))
    possible = np.abs(missing).max(axis=1) <= _MAX_MISSING * np.maximum(scale, _SMALL)
    strength = np.full(len(b), np.inf)
    if possible.any():
        arrays = (A, b - missing, low, high)
        strength[possible] = _strength(*(array[possible] for array in arrays))
    return strength


def _columns(
    terms: MotionTerms, failed: Sequence[int], low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return rows of L and limits of non-negative forces, shape (T, m, n) and (T, m).

    Failed actuators have zero rows. Motors have a row for each sign, so that a factor scales both
    limits of their torques.
    """
    shape = terms.L.shape[:2]
    L, low = terms.L.copy(), np.array(np.broadcast_to(low, shape))
    L[:, list(failed)], low[:, list(failed)] = 0.0, 0.0
    return split_motors(L, low, np.broadcast_to(high, shape), terms.motors)


def _missing_torque(A: FloatArray, b: FloatArray, low: FloatArray) -> FloatArray:
    """Return the smallest b - A f with f >= low, shape (k, n).

    Args:
        A: Shape (k, n, m).
        b: Shape (k, n).
        low: Lower limits of forces, shape (k, m), in [N].
    """
    from scipy.sparse import block_diag, hstack, identity

    k, n, m = A.shape
    eye = identity(k * n)
    cost = np.append(np.zeros(k * m), np.ones(2 * k * n))
    least = np.append(low, np.zeros(2 * k * n))
    x = _solve(cost, hstack([block_diag(A), eye, -eye]), b.ravel(), least)
    more, less = x[k * m :].reshape(2, k, n)
    return np.asarray(more - less)


def _strength(A: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the smallest s with A f = b and low <= f <= s high, shape (k,); see above."""
    from scipy.sparse import block_diag, csr_matrix, hstack

    k, _, m = A.shape
    point, muscle = np.nonzero(np.isfinite(high))
    rows, columns = np.arange(len(point)), point * m + muscle
    ones = np.ones(len(point))
    f = csr_matrix((ones, (rows, columns)), shape=(len(point), k * m))
    s = csr_matrix((-high[point, muscle], (rows, point)), shape=(len(point), k))
    equal = hstack([block_diag(A), csr_matrix((b.size, k))])
    cost = np.append(np.zeros(k * m), np.ones(k))
    upper = {"A_ub": hstack([f, s]), "b_ub": np.zeros(len(point))}
    x = _solve(cost, equal, b.ravel(), np.append(low, np.zeros(k)), **upper)
    return x[k * m :]


def _solve(cost: FloatArray, A: Any, b: FloatArray, low: FloatArray, **upper: Any) -> FloatArray:
    """Minimise cost'x subject to A x = b, x >= low and the inequalities."""
    answer = linear_program(cost, low, np.full(low.shape, np.inf), A_eq=A, b_eq=b, **upper)
    if answer.status:
        raise SimulationError(f"HiGHS does not solve the linear program: {answer.message}")
    return np.asarray(answer.x)
