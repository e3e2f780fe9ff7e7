"""Readings of a robot that moves, and the short windows that they are cut into."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.muscles.cable_slip import CableSlip
from sim_dart.muscles.paths import MusclePaths

_DEGREE = 5
"""Of the polynomials in time that a window's readings are compared with, for their noise."""

_MIN_NOISE = 1e-7
"""In [rad] or [m]: what steps of a millisecond make of a motion has errors, too."""


@dataclass(frozen=True, eq=False)
class Readings:
    """A recording of K readings at equal steps; NaN is a reading that is missing.

    Attributes:
        name: What users know it by.
        step: In [s].
        q: Positions by encoders, shape (K, n), in [rad] or [m].
        lengths: Of muscles at their motors, shape (K, m), in [m].
        tensions: From each reading to the next, shape (K, m), in [N].
        torques: Of motors at joints, shape (K, n), in [N·m] or [N].
        markers: Of M markers, as seen in the world, shape (K, 3 M), in [m]; hidden ones are NaN.
        shown: q with what markers show if there is no encoder; q itself when None.
    """

    name: str
    step: float
    q: FloatArray
    lengths: FloatArray
    tensions: FloatArray
    torques: FloatArray
    markers: FloatArray | None = None
    shown: FloatArray | None = None

    @property
    def poses(self) -> FloatArray:
        """Positions by whatever shows them, shape (K, n), in [rad] or [m]."""
        return self.q if self.shown is None else self.shown

    @property
    def columns(self) -> FloatArray:
        """What is compared with roll-outs, q, lengths and markers, shape (K, n + m + 3 M)."""
        return np.hstack([self.q, self.lengths, *([] if self.markers is None else [self.markers])])

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


def slips_along(robot: Robot, poses: FloatArray, steps: int) -> FloatArray:
    """How the cables of a robot rub along poses, from neither way on and behind each gap.

    Args:
        robot: The robot.
        poses: Shape (K, n); NaN is a reading that is missing.
        steps: Steps between two readings, as roll-outs have them.

    Returns:
        The states of bends, shape (K, bends).
    """
    paths = MusclePaths(robot)
    slip, found = CableSlip(paths), np.zeros((len(poses), paths.bends))
    before = np.full(poses.shape[1], np.nan)
    for row, q in zip(found, poses, strict=True):
        if np.isnan(q).any():
            slip.reset()
        elif np.isnan(before).any():
            slip.follow(q)
        else:
            for k in range(1, steps + 1):
                slip.follow(before + k / steps * (q - before))
            row[:] = slip.get_state()[: paths.bends]
        before = q
    return found


class Window(NamedTuple):
    """Readings in a row, without a gap.

    Attributes:
        readings: The recording.
        first: Its first reading.
        measured: The readings' columns, shape (rows, n + m + 3 M); NaN if there is no sensor,
            or a marker is hidden.
    """

    readings: Readings
    first: int
    measured: FloatArray


def windows(recordings: Sequence[Readings], duration: float) -> list[Window]:
    """All windows of a duration, in [s], without a missing reading; one begins where one ends."""
    return [window for readings in recordings for window in _windows(readings, duration)]


def _windows(readings: Readings, duration: float) -> Iterator[Window]:
    rows = max(round(duration / readings.step), 2 * _DEGREE)
    measured, poses = readings.columns, readings.poses
    needed = np.hstack([poses, readings.lengths])
    absent = np.isnan(needed).all(axis=0)
    whole = np.asarray(~np.isnan(needed[:, ~absent]).any(axis=1))
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
    """Standard deviation of one reading, about smooth motions, shape (n + m + 3 M,).

    Columns that are whole in no window, as of a marker that is often hidden, get the greatest.
    """
    left = [_smooth(window.measured)[1] for window in cut]
    squares = np.array([(r**2).sum(axis=0) / (len(r) - _DEGREE - 1) for r in left])
    known = ~np.isnan(squares)
    variance = np.where(known, squares, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    variance[~known.any(axis=0)] = variance.max()
    return np.asarray(np.maximum(np.sqrt(variance), _MIN_NOISE))


def smooth_start(window: Window) -> FloatArray:
    """Q and qd at a window's first reading, by a polynomial through all, shape (2 n,)."""
    rows, readings = len(window.measured), window.readings
    polynomial, _ = _smooth(readings.poses[window.first : window.first + rows])
    span = (rows - 1) * readings.step
    value = np.polynomial.chebyshev.chebval(-1.0, polynomial)
    slope = np.polynomial.chebyshev.chebder(polynomial)
    return np.concatenate([value, np.polynomial.chebyshev.chebval(-1.0, slope) * 2.0 / span])


def _smooth(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Coefficients over the rows of a window, and what is left, of their shape."""
    V = np.polynomial.chebyshev.chebvander(np.linspace(-1, 1, len(rows)), _DEGREE)
    c: FloatArray = np.linalg.lstsq(V, rows, rcond=None)[0].astype(np.float64)
    return c, rows - V @ c
