"""Recordings of a robot's motion, and the short windows into which they are divided."""

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
"""Degree of the polynomials in time that smooth the measurements of a window."""

_MIN_NOISE = 1e-7
"""Smallest noise, in [rad] or [m], due to integration errors with steps of 1 ms."""


@dataclass(frozen=True, eq=False)
class Recording:
    """Recording of K measurements with a constant period. Missing values are NaN.

    Attributes:
        name: Name for messages.
        step: Sampling period, in [s].
        q: Encoder positions, shape (K, n), in [rad] or [m].
        lengths: Muscle lengths at the motors, shape (K, m), in [m].
        tensions: Tensions until the next measurement, shape (K, m), in [N].
        torques: Torques of joint motors, shape (K, n), in [N·m] or [N].
        markers: World positions of M markers, shape (K, 3 M), in [m]; NaN for hidden markers.
        completed: q with missing encoder positions determined from markers, or None for q.
    """

    name: str
    step: float
    q: FloatArray
    lengths: FloatArray
    tensions: FloatArray
    torques: FloatArray
    markers: FloatArray | None = None
    completed: FloatArray | None = None

    @property
    def poses(self) -> FloatArray:
        """Joint positions from encoders or markers, shape (K, n), in [rad] or [m]."""
        return self.q if self.completed is None else self.completed

    @property
    def columns(self) -> FloatArray:
        """Measurements that are compared with roll-outs, shape (K, n + m + 3 M)."""
        return np.hstack([self.q, self.lengths, *([] if self.markers is None else [self.markers])])

    def delayed_tensions(
        self, first: int, rows: int, delay: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return tensions corrected by a delay, and their derivative, shape (rows, m) each.

        Args:
            first: Index of the first measurement.
            rows: Number of measurements.
            delay: Delay of recorded tensions, in [s].
        """
        steps = int(np.floor(delay / self.step))
        share = delay / self.step - steps
        last = len(self.tensions) - 1
        at = np.clip(np.arange(first + steps, first + steps + rows + 1), 0, last)
        read = self.tensions[at]
        valid = ~np.isnan(read).any(axis=1)  # a gap may follow a window: keep the last value
        filled = read[np.maximum.accumulate(np.where(valid, np.arange(rows + 1), 0))]
        earlier, later = filled[:-1], filled[1:]
        return (1.0 - share) * earlier + share * later, (later - earlier) / self.step


def slip_states_along(robot: Robot, poses: FloatArray, steps: int) -> FloatArray:
    """Compute the slip states of cables along poses. They are reset to 0 after each gap.

    Args:
        poses: Poses, shape (K, n), with NaN for missing measurements.
        steps: Steps between two measurements, as in roll-outs.

    Returns:
        The slip states, shape (K, bends).
    """
    paths = MusclePaths(robot)
    slip, states = CableSlip(paths), np.zeros((len(poses), paths.bends))
    before = np.full(poses.shape[1], np.nan)
    for row, q in zip(states, poses, strict=True):
        if np.isnan(q).any():
            slip.reset()
        elif np.isnan(before).any():
            slip.follow(q)
        else:
            for k in range(1, steps + 1):
                slip.follow(before + k / steps * (q - before))
            row[:] = slip.get_state()[: paths.bends]
        before = q
    return states


class Window(NamedTuple):
    """Consecutive measurements without a gap.

    Attributes:
        first: Index of the first measurement.
        measured: The measurements, shape (rows, n + m + 3 M); NaN for missing sensors and hidden
            markers.
    """

    recording: Recording
    first: int
    measured: FloatArray


def cut_windows(recordings: Sequence[Recording], duration: float) -> list[Window]:
    """Divide recordings into consecutive windows of a duration, in [s], without gaps."""
    return [window for recording in recordings for window in _windows_of(recording, duration)]


def _windows_of(recording: Recording, duration: float) -> Iterator[Window]:
    rows = max(round(duration / recording.step), 2 * _DEGREE)
    measured, poses = recording.columns, recording.poses
    needed = np.hstack([poses, recording.lengths])
    absent = np.isnan(needed).all(axis=0)
    complete = np.asarray(~np.isnan(needed[:, ~absent]).any(axis=1))
    complete &= ~np.isnan(recording.tensions).any(axis=1) & ~np.isnan(recording.torques).any(axis=1)
    first = 0
    while first + rows <= len(measured):
        gaps = np.flatnonzero(~complete[first : first + rows])
        if len(gaps):
            first += int(gaps[-1]) + 1
            continue
        yield Window(recording, first, measured[first : first + rows])
        first += rows


def measurement_noise(windows: Sequence[Window]) -> FloatArray:
    """Estimate the standard deviation of measurements from windows, shape (n + m + 3 M,).

    Columns without any complete window, such as markers that are often hidden, get the largest
    value.
    """
    residuals = [_smooth(window.measured)[1] for window in windows]
    squares = np.array([(r**2).sum(axis=0) / (len(r) - _DEGREE - 1) for r in residuals])
    valid = ~np.isnan(squares)
    variance = np.where(valid, squares, 0.0).sum(axis=0) / np.maximum(valid.sum(axis=0), 1)
    variance[~valid.any(axis=0)] = variance.max()
    return np.asarray(np.maximum(np.sqrt(variance), _MIN_NOISE))


def smoothed_start(window: Window) -> FloatArray:
    """Return q and qd at the start of a window from fitted polynomials, shape (2 n,)."""
    rows, recording = len(window.measured), window.recording
    polynomial, _ = _smooth(recording.poses[window.first : window.first + rows])
    span = (rows - 1) * recording.step
    value = np.polynomial.chebyshev.chebval(-1.0, polynomial)
    slope = np.polynomial.chebyshev.chebder(polynomial)
    return np.concatenate([value, np.polynomial.chebyshev.chebval(-1.0, slope) * 2.0 / span])


def _smooth(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Fit polynomials to the rows of a window, and return coefficients and residuals."""
    V = np.polynomial.chebyshev.chebvander(np.linspace(-1, 1, len(rows)), _DEGREE)
    c: FloatArray = np.linalg.lstsq(V, rows, rcond=None)[0].astype(np.float64)
    return c, rows - V @ c
