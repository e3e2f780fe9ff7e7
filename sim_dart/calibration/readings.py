"""Readings of a robot that moves, and the short windows that they are cut into."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sim_dart.core.arrays import FloatArray

_DEGREE = 5
"""Of the polynomials in time that a window's readings are compared with, for their noise."""

_LEAST_NOISE = 1e-7
"""In [rad] or [m]: what steps of a millisecond make of a motion has errors, too."""


@dataclass(frozen=True)
class Readings:
    """A recording of K readings at equal steps; NaN is a reading that is missing.

    Attributes:
        name: What users know it by.
        step: In [s].
        q: Positions by encoders or markers, shape (K, n), in [rad] or [m].
        lengths: Of muscles at their motors, shape (K, m), in [m].
        tensions: From each reading to the next, shape (K, m), in [N].
        torques: Of motors at joints, shape (K, n), in [N·m] or [N].
    """

    name: str
    step: float
    q: FloatArray
    lengths: FloatArray
    tensions: FloatArray
    torques: FloatArray

    def delayed_tensions(
        self, first: int, rows: int, delay: float
    ) -> tuple[FloatArray, FloatArray]:
        """Tensions that are read late, and their derivative by the delay, shape (rows, m) each.

        Args:
            first: The first reading.
            rows: How many.
            delay: By which a tension is in the recording after it has acted, in [s].
        """
        whole = int(np.floor(delay / self.step))
        part = delay / self.step - whole
        last = len(self.tensions) - 1
        at = np.clip(np.arange(first + whole, first + whole + rows + 1), 0, last)
        read = self.tensions[at]
        sound = ~np.isnan(read).any(axis=1)  # behind a window there may be a gap: as before it
        held = read[np.maximum.accumulate(np.where(sound, np.arange(rows + 1), 0))]
        here, next_ = held[:-1], held[1:]
        return (1.0 - part) * here + part * next_, (next_ - here) / self.step


class Window(NamedTuple):
    """Readings in a row, without a gap.

    Attributes:
        readings: The recording.
        first: Its first reading.
        measured: q, then lengths, shape (rows, n + m); NaN in columns without a sensor.
    """

    readings: Readings
    first: int
    measured: FloatArray


def windows(recordings: Sequence[Readings], duration: float) -> list[Window]:
    """All windows of a duration, in [s], without a missing reading; one begins where one ends."""
    return [window for readings in recordings for window in _windows(readings, duration)]


def _windows(readings: Readings, duration: float) -> Iterator[Window]:
    rows = max(round(duration / readings.step), 2 * _DEGREE)
    measured = np.hstack([readings.q, readings.lengths])
    absent = np.isnan(measured).all(axis=0)
    whole = np.asarray(~np.isnan(measured[:, ~absent]).any(axis=1))
    whole &= ~np.isnan(readings.tensions).any(axis=1) & ~np.isnan(readings.torques).any(axis=1)
    first = 0
    while first + rows <= len(measured):
        gaps = np.flatnonzero(~whole[first : first + rows])
        if len(gaps):
            first += int(gaps[-1]) + 1
            continue
        yield Window(readings, first, measured[first : first + rows])
        first += rows


def noise(cut: Sequence[Window]) -> FloatArray:
    """Standard deviation of one reading of q and lengths, about smooth motions, shape (n + m,)."""
    left = [_smooth(window)[1] for window in cut]
    variance = np.mean([(r**2).sum(axis=0) / (len(r) - _DEGREE - 1) for r in left], axis=0)
    return np.asarray(np.maximum(np.sqrt(variance), _LEAST_NOISE))


def smooth_start(window: Window, n: int) -> FloatArray:
    """Q and qd at a window's first reading, by a polynomial through all, shape (2 n,)."""
    polynomial, _ = _smooth(window)
    span = (len(window.measured) - 1) * window.readings.step
    value = np.polynomial.chebyshev.chebval(-1.0, polynomial[:, :n])
    slope = np.polynomial.chebyshev.chebder(polynomial[:, :n])
    return np.concatenate([value, np.polynomial.chebyshev.chebval(-1.0, slope) * 2.0 / span])


def _smooth(window: Window) -> tuple[FloatArray, FloatArray]:
    """Coefficients over a window, and what is left, shape (rows, n + m)."""
    V = np.polynomial.chebyshev.chebvander(np.linspace(-1, 1, len(window.measured)), _DEGREE)
    c: FloatArray = np.linalg.lstsq(V, window.measured, rcond=None)[0].astype(np.float64)
    return c, window.measured - V @ c
