"""Levenberg-Marquardt method for calibration problems."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from addin_sdfusion.robot import CardsflowError
from sim_dart.core.arrays import FloatArray

from .problem import CalibrationProblem, Linearisation
from .recordings import Window
from .window_starts import FittedWindows

_MAX_ITERATIONS = 30
_MAX_REJECTED_STEPS = 12
_DAMPING = 1e-7
"""Initial damping. Larger values slow down parameters with little information."""

_MIN_GAIN = 0.3
"""Smallest gain of an iteration, in mean squares of residuals.

This is a third of the change that one standard deviation of a parameter causes.
"""


@dataclass(frozen=True)
class Fit:
    """Solution of a calibration problem.

    Attributes:
        z: Changes of the parameters over their prior sd, shape (P,).
        information: Information matrix H of theta in units of the prior, with eliminated start
            states, at the last linearisation, shape (P, P).
        windows: The fitted windows at z.
    """

    z: FloatArray
    information: FloatArray
    windows: FittedWindows
    iterations: int
    converged: bool


def fit(
    problem: CalibrationProblem,
    windows: Sequence[Window],
    z: FloatArray | None = None,
    max_iterations: int = _MAX_ITERATIONS,
    small_gain: float = 0.0,
    end_of_iteration: Callable[[], None] = lambda: None,
) -> Fit:
    """Solve a calibration problem.

    Args:
        z: Initial value (default: zeros).
        small_gain: Relative gain of the cost below which the iterations stop.
        end_of_iteration: Called after each iteration.

    Raises:
        CardsflowError: The robot diverges within the windows at the initial value.
    """
    z = np.zeros(len(problem.parameters)) if z is None else z
    z, damping = np.clip(z, problem.low, problem.high), _DAMPING
    rows = sum(window.measured.size for window in windows)
    fitted = problem.fit_windows(z, windows)
    for iteration in range(1, max_iterations + 1):
        at = None if fitted is None else problem.linearise(z, windows, fitted.starts)
        if fitted is None or at is None:
            raise CardsflowError(
                "the robot diverges within the recording's windows; check that the "
                "recording is from this robot"
            )
        before = fitted.cost + problem.prior(z)[0]
        min_gain = max(small_gain * before, _MIN_GAIN * max(before / rows, 1.0))
        predicted = -float((at.gradient + problem.prior(z)[1]) @ _step(problem, at, z, 0.0))
        if predicted <= min_gain:
            return Fit(z, at.information, fitted, iteration, True)
        for _ in range(_MAX_REJECTED_STEPS):
            new_z = np.clip(z + _step(problem, at, z, damping), problem.low, problem.high)
            new = _evaluate_step(problem, windows, fitted, at, new_z - z, new_z)
            after = np.inf if new is None else new.cost + problem.prior(new_z)[0]
            if new is not None and after <= before:
                break
            damping = max(damping * 10.0, 1e-6)
        else:
            return Fit(z, at.information, fitted, iteration, True)
        z, fitted, damping = new_z, new, damping / 10.0
        end_of_iteration()
        ends = before - after <= min_gain
        if ends or iteration == max_iterations:
            return Fit(z, at.information, fitted, iteration, ends)
    raise AssertionError


def _evaluate_step(
    problem: CalibrationProblem,
    windows: Sequence[Window],
    fitted: FittedWindows,
    at: Linearisation,
    step: FloatArray,
    z: FloatArray,
) -> FittedWindows | None:
    """Return the fitted windows after a step, with predicted start states, or None."""
    if not np.isfinite(problem.prior(z)[0]):
        return None
    moved = problem.moved_starts(fitted.starts, at.windows, step)
    solvers = [window.start_solver for window in at.windows]
    return problem.fit_windows(z, windows, moved, solvers)


def _step(
    problem: CalibrationProblem, at: Linearisation, z: FloatArray, damping: float
) -> FloatArray:
    """Return the Levenberg-Marquardt step. Parameters at an active bound do not change."""
    _, slope, curvature = problem.prior(z)
    H, g = at.information + curvature, at.gradient + slope
    free = ~((z <= problem.low) & (g > 0.0) | (z >= problem.high) & (g < 0.0))
    step = np.zeros(len(z))
    if free.any():
        H_free = H[np.ix_(free, free)]
        scaled = H_free + damping * np.diag(np.diag(H_free))
        step[free] = -np.linalg.solve(scaled, g[free])
    return step
