"""Levenberg and Marquardt's method for calibrations: derivatives where it goes, costs at trials."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from addin_sdfusion.robot import CardsflowError
from sim_dart.core.arrays import FloatArray

from .problem import CalibrationProblem, Linearised
from .readings import Window
from .starts import Settled

_MAX_ITERATIONS = 30
_MAX_REFUSALS = 12
_DAMPING = 1e-7
"""At first: with more, numbers that are seen the least hardly move for some iterations."""

_MIN_GAIN = 0.3
"""In mean squares of residuals: a third of what one standard deviation of a number changes."""


@dataclass(frozen=True)
class Fit:
    """A calibration.

    Attributes:
        z: Changes of the parameters over their priors' sd, shape (P,).
        information: H of theta in units of the prior, starts eliminated, where the last step was
            taken from, shape (P, P).
        settled: The windows at z.
        iterations: How many it took.
        converged: Whether the last one changed nothing.
    """

    z: FloatArray
    information: FloatArray
    settled: Settled
    iterations: int
    converged: bool


def fit(
    problem: CalibrationProblem,
    cut: Sequence[Window],
    z: FloatArray | None = None,
    most: int = _MAX_ITERATIONS,
    small_gain: float = 0.0,
    end_of_iteration: Callable[[], None] = lambda: None,
) -> Fit:
    """Solve a calibration.

    Args:
        problem: It.
        cut: The windows.
        z: Where to begin; zeros if omitted.
        most: Most iterations.
        small_gain: Part of the cost; an iteration that gains less is the last, as is one that gains
            less than any deviation.
        end_of_iteration: Called after each iteration.

    Raises:
        CardsflowError: The robot diverges within windows where it begins.
    """
    z = np.zeros(len(problem.parameters)) if z is None else z
    z, damping = np.clip(z, problem.low, problem.high), _DAMPING
    rows = sum(window.measured.size for window in cut)
    settled = problem.settled(z, cut)
    for iteration in range(1, most + 1):
        at = None if settled is None else problem.linearise(z, cut, settled.starts)
        if settled is None or at is None:
            raise CardsflowError(
                "the robot diverges within the recording's windows; check that the "
                "recording is from this robot"
            )
        before = settled.cost + problem.prior(z)[0]
        least = max(small_gain * before, _MIN_GAIN * max(before / rows, 1.0))
        if _foreseen_gain(problem, at, z) <= least:
            return Fit(z, at.information, settled, iteration, True)
        for _ in range(_MAX_REFUSALS):
            new_z = np.clip(z + _step(problem, at, z, damping), problem.low, problem.high)
            new = _tried(problem, cut, settled, at, new_z - z, new_z)
            after = np.inf if new is None else new.cost + problem.prior(new_z)[0]
            if new is not None and after <= before:
                break
            damping = max(damping * 10.0, 1e-6)
        else:
            return Fit(z, at.information, settled, iteration, True)
        z, settled, damping = new_z, new, damping / 10.0
        end_of_iteration()
        ends = before - after <= least
        if ends or iteration == most:
            return Fit(z, at.information, settled, iteration, ends)
    raise AssertionError


def _tried(
    problem: CalibrationProblem,
    cut: Sequence[Window],
    settled: Settled,
    at: Linearised,
    step: FloatArray,
    z: FloatArray,
) -> Settled | None:
    """Windows after a step, their starts fitted again from where derivatives say; or None."""
    if not np.isfinite(problem.prior(z)[0]):
        return None
    moved = [
        x + change + slope @ step
        for x, change, slope in zip(settled.starts, at.start_changes, at.start_slopes, strict=True)
    ]
    return problem.settled(z, cut, moved, at.start_solvers)


def _foreseen_gain(problem: CalibrationProblem, at: Linearised, z: FloatArray) -> float:
    """By how much a whole step would lower the cost, were the windows linear in it."""
    return -float((at.gradient + problem.prior(z)[1]) @ _step(problem, at, z, 0.0))


def _step(problem: CalibrationProblem, at: Linearised, z: FloatArray, damping: float) -> FloatArray:
    """Of Levenberg and Marquardt; what is at its bound and would leave it stays."""
    _, slope, bend = problem.prior(z)
    H, g = at.information + bend, at.gradient + slope
    free = ~((z <= problem.low) & (g > 0.0) | (z >= problem.high) & (g < 0.0))
    step = np.zeros(len(z))
    if free.any():
        part = H[np.ix_(free, free)]
        scaled = part + damping * np.diag(np.diag(part))
        step[free] = -np.linalg.solve(scaled, g[free])
    return step
