"""Start states of windows: fit for fixed parameters, and elimination.

With A = dr/dx, B = dr/dtheta and A = Q R, the residuals after elimination of the start state are
(I - Q Q') (r + B dtheta) (Golub & Pereyra 2003, Inverse Problems 19).
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
"""Relative gain of the cost of a window below which its start state is fitted."""

Residuals = tuple[FloatArray, FloatArray]
"""Residuals of a window, shape (rows, columns), and their derivatives, shape (rows, columns,
directions). The last directions are the start state."""


class ReducedWindow(NamedTuple):
    """Linearisation of a window after elimination of its start state.

    Attributes:
        residuals: Normalised residuals r, shape (measurements,).
        jacobian: Derivatives by the parameters that the start state cannot compensate,
            (I - Q Q') B, shape (measurements, P).
        start_change: Change of the start state for fixed parameters, shape (2 n,).
        start_slope: Derivative of the start state by the parameters, shape (2 n, P).
        start_solver: Matrix from normalised residuals to the change of the start state, shape
            (2 n, measurements).
    """

    residuals: FloatArray
    jacobian: FloatArray
    start_change: FloatArray
    start_slope: FloatArray
    start_solver: FloatArray

    @property
    def information(self) -> FloatArray:
        """Information matrix of the parameters, shape (P, P)."""
        return self.jacobian.T @ self.jacobian


@dataclass(frozen=True)
class FittedWindows:
    """Windows with start states that are fitted for fixed theta.

    Attributes:
        cost: Sum of squared normalised residuals, without the prior.
        starts: Start states, shape (2 n,) each.
        residuals: Residuals of each window in units of measurements, shape (rows, n + m + 3 M).
    """

    cost: float
    starts: list[FloatArray]
    residuals: list[FloatArray]


def fit_start(
    roll: Callable[[FloatArray, bool], Residuals | None],
    start: FloatArray,
    noise: FloatArray,
    solver: FloatArray | None = None,
) -> FittedWindows | None:
    """Fit the start state of a window by the Levenberg-Marquardt method.

    Args:
        roll: Function for residuals of the window from a start state, with or without
            derivatives.
        start: Initial start state, shape (2 n,).
        noise: Standard deviation of one measurement, shape (columns,).
        solver: `start_solver` of a linearisation nearby, which can avoid derivatives.

    Returns:
        The fitted window, or None if it diverges.
    """
    fitted = None if solver is None else _fit_start_with_solver(roll, start, noise, solver)
    if fitted is not None:
        return fitted
    linearised, damping = roll(start, True), 0.0
    if linearised is None:
        return None
    r, A = _normalise(*linearised, noise)
    cost, residuals = float(r @ r), linearised[0]
    for _ in range(_ITERATIONS):
        H = A.T @ A
        damped = H + damping * np.diag(np.diag(H))
        step = -np.linalg.pinv(damped, rcond=1e-12, hermitian=True) @ (A.T @ r)
        tried = roll(start + step, False)
        new, _ = (None, None) if tried is None else _normalise(*tried, noise)
        after = np.inf if new is None else float(new @ new)
        if tried is None or after > cost:
            damping = max(10.0 * damping, 1e-2)
            if damping > _MAX_DAMPING:
                break
            continue
        gain, start, cost, residuals, damping = (
            cost - after,
            start + step,
            after,
            tried[0],
            damping / 10.0,
        )
        if gain <= _GAIN:
            break
        linearised = roll(start, True)
        assert linearised is not None
        r, A = _normalise(*linearised, noise)
    return FittedWindows(cost, [start], [residuals])


def _fit_start_with_solver(
    roll: Callable[[FloatArray, bool], Residuals | None],
    start: FloatArray,
    noise: FloatArray,
    solver: FloatArray,
) -> FittedWindows | None:
    """Fit the start state with a fixed solver; return None if this does not converge."""
    current = roll(start, False)
    for _ in range(_NEAR_ITERATIONS):
        if current is None:
            return None
        r = normalise(current[0], noise)
        moved = start + solver @ r
        changed = roll(moved, False)
        if changed is None:
            return None
        new = normalise(changed[0], noise)
        gain = float(r @ r - new @ new)
        if gain < -_NEAR_GAIN:
            return None
        if gain < 0.0:
            return FittedWindows(float(r @ r), [start], [current[0]])
        start, current = moved, changed
        if gain <= _NEAR_GAIN:
            return FittedWindows(float(new @ new), [start], [current[0]])
    return None


def eliminate(residuals: Residuals, size: int, noise: FloatArray) -> ReducedWindow:
    """Eliminate the start state of a window.

    Args:
        residuals: Residuals and derivatives of the window.
        size: Size of the start state, 2 n.
        noise: Standard deviation of one measurement, shape (columns,).
    """
    r, J = _normalise(*residuals, noise)
    A, B = J[:, -size:], J[:, :-size]
    Q, R = np.linalg.qr(A)
    inverse, QB = np.linalg.pinv(R, rcond=1e-10), Q.T @ B
    return ReducedWindow(r, B - Q @ QB, -inverse @ (Q.T @ r), -inverse @ QB, -inverse @ Q.T)


def normalise(residuals: FloatArray, noise: FloatArray) -> FloatArray:
    """Return residuals over noise without missing measurements, shape (measurements,)."""
    return _normalise(residuals, np.zeros((*residuals.shape, 0)), noise)[0]


def _normalise(
    residuals: FloatArray, slopes: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return residuals and derivatives over noise without missing measurements."""
    valid = ~np.isnan(residuals).ravel()
    weight = np.broadcast_to(1.0 / noise, residuals.shape).ravel()[valid]
    J = slopes.reshape(residuals.size, slopes.shape[2])[valid] * weight[:, None]
    return residuals.ravel()[valid] * weight, J
