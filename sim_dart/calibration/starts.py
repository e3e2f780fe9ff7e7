"""Where windows begin: fitted with the robot's numbers held, or eliminated from them.

With A = dr/dx and B = dr/dtheta of a window and A = Q R, what is left of it with its start
eliminated is (I - Q Q') (r + B dtheta) (Golub & Pereyra 2003, Inverse Problems 19).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sim_dart.core.arrays import FloatArray

_ITERATIONS = 40
_NEAR_ITERATIONS, _NEAR_GAIN = 6, 1e-3
_MAX_DAMPING = 1e6
_GAIN = 1e-2
"""Of a window's cost, below which its start is fitted: of thousands of readings' squares."""

Left = tuple[FloatArray, FloatArray]
"""Remainder of a window's readings, shape (rows, columns), and its derivatives, shape (rows,
columns, directions), the last of which are those by the start."""


class Eliminated(NamedTuple):
    """A window, linear in the changes of some numbers and of its start.

    Attributes:
        information: H of the numbers, shape (P, P).
        gradient: Shape (P,).
        start_change: Of the start, with the numbers held, shape (2 n,).
        start_slope: How the start follows the numbers, shape (2 n, P).
        start_solver: The start's change by what is left over the noise, shape (2 n, readings).
    """

    information: FloatArray
    gradient: FloatArray
    start_change: FloatArray
    start_slope: FloatArray
    start_solver: FloatArray


@dataclass(frozen=True)
class Settled:
    """Windows with theta held, each beginning where it fits best.

    Attributes:
        cost: Sum of squared residuals, without the prior.
        starts: Shape (2 n,) each.
        residuals: Of each window, in units of readings, shape (rows, n + m + 3 M).
    """

    cost: float
    starts: list[FloatArray]
    residuals: list[FloatArray]


def settle(
    roll: Callable[[FloatArray, bool], Left | None],
    start: FloatArray,
    noise: FloatArray,
    solver: FloatArray | None = None,
) -> Settled | None:
    """Levenberg and Marquardt's method for the start of one window; None if it diverges.

    Args:
        roll: Remainder of the window from a start on, with derivatives by it or without.
        start: Where to look from, shape (2 n,).
        noise: Of one reading, shape (columns,).
        solver: `start_solver` of somewhere near, which may do without any derivatives.
    """
    found = None if solver is None else _settled_by(roll, start, noise, solver)
    if found is not None:
        return found
    here, damping = roll(start, True), 0.0
    if here is None:
        return None
    r, A = _whitened(*here, noise)
    cost, left = float(r @ r), here[0]
    for _ in range(_ITERATIONS):
        H = A.T @ A
        damped = H + damping * np.diag(np.diag(H))
        step = -np.linalg.pinv(damped, rcond=1e-12, hermitian=True) @ (A.T @ r)
        tried = roll(start + step, False)
        new, _ = (None, None) if tried is None else _whitened(*tried, noise)
        after = np.inf if new is None else float(new @ new)
        if tried is None or after > cost:
            damping = max(10.0 * damping, 1e-2)
            if damping > _MAX_DAMPING:
                break
            continue
        gain, start, cost, left, damping = (
            cost - after,
            start + step,
            after,
            tried[0],
            damping / 10.0,
        )
        if gain <= _GAIN:
            break
        here = roll(start, True)
        assert here is not None
        r, A = _whitened(*here, noise)
    return Settled(cost, [start], [left])


def _settled_by(
    roll: Callable[[FloatArray, bool], Left | None],
    start: FloatArray,
    noise: FloatArray,
    solver: FloatArray,
) -> Settled | None:
    """Return the same with derivatives of somewhere near; None if these do not get there."""
    here = roll(start, False)
    for _ in range(_NEAR_ITERATIONS):
        if here is None:
            return None
        r = whitened(here[0], noise)
        moved = start + solver @ r
        there = roll(moved, False)
        if there is None:
            return None
        new = whitened(there[0], noise)
        gain = float(r @ r - new @ new)
        if gain < -_NEAR_GAIN:
            return None
        if gain < 0.0:
            return Settled(float(r @ r), [start], [here[0]])
        start, here = moved, there
        if gain <= _NEAR_GAIN:
            return Settled(float(new @ new), [start], [here[0]])
    return None


def eliminate(left: Left, size: int, noise: FloatArray) -> Eliminated:
    """Return a window with its start eliminated.

    Args:
        left: Of the window, with derivatives by the numbers and the start.
        size: Of the start: 2 n.
        noise: Of one reading, shape (columns,).
    """
    r, J = _whitened(*left, noise)
    A, B = J[:, -size:], J[:, :-size]
    Q, R = np.linalg.qr(A)
    inverse = np.linalg.pinv(R, rcond=1e-10)
    Qr, QB = Q.T @ r, Q.T @ B
    H, g = B.T @ B - QB.T @ QB, B.T @ r - QB.T @ Qr
    return Eliminated(H, g, -inverse @ Qr, -inverse @ QB, -inverse @ Q.T)


def without_start(left: Left, size: int, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the part of a window's derivatives by numbers that no start compensates for.

    Args:
        left: Of the window, with derivatives by the numbers and the start.
        size: Of the start: 2 n.
        noise: Of one reading, shape (columns,).

    Returns:
        (I - Q Q') B, shape (readings, P), and how the start follows the numbers, shape (2 n, P).
    """
    _, J = _whitened(*left, noise)
    A, B = J[:, -size:], J[:, :-size]
    Q, R = np.linalg.qr(A)
    QB = Q.T @ B
    return B - Q @ QB, -np.linalg.pinv(R, rcond=1e-10) @ QB


def whitened(left: FloatArray, noise: FloatArray) -> FloatArray:
    """Residuals over the noise, without readings that there are not, shape (readings,)."""
    return _whitened(left, np.zeros((*left.shape, 0)), noise)[0]


def _whitened(
    left: FloatArray, slopes: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Residuals and derivatives over the noise, without readings that there are not."""
    taken = ~np.isnan(left).ravel()
    weight = np.broadcast_to(1.0 / noise, left.shape).ravel()[taken]
    J = slopes.reshape(left.size, slopes.shape[2])[taken] * weight[:, None]
    return left.ravel()[taken] * weight, J
