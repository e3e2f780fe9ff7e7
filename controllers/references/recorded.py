"""Trajectories through waypoints and along recorded samples."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.model.trajectory import Space, Spline, Trajectory, TrajectoryPoint
from controllers.arrays import FloatArray
from controllers.references.smoothing import smoothing_spline

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

_MAX_NOISE = 1e100  # its square must be representable as a float

MIN_SAMPLES = 6
"""Minimum number of samples of a smoothing spline."""

# Knots per sample. If a spline requires more, the sampling is too coarse to separate noise and
# motion.
_MAX_KNOTS = 0.75
_MAX_ORDER = 12  # of differences for the estimate of the noise
_MIN_NOISE = 1e-9  # relative to the range of the samples; smaller noise is rounding error


@np.errstate(all="ignore")  # values that overflow are rejected at the end
def waypoint_trajectory(
    times: FloatArray, q: FloatArray, name: str = "waypoints", space: Space = "joint"
) -> Trajectory:
    """Return the minimum-jerk motion through waypoints, which starts and ends at rest.

    The motion does not stop at waypoints. It minimises the integral of the squared third
    derivative. The result is a spline of fifth order with continuous derivatives up to the fourth.

    Args:
        times: Times of the waypoints, shape (m,), m >= 2, increasing from 0, in [s].
        q: Positions, shape (m, n), in [rad] or [m].
        space: Whether q contains joint positions or task coordinates.

    Raises:
        InputError: A shape is wrong, a number is not finite, or the times do not increase from 0.
    """
    _require_motion(times, q, 2)
    rest = np.zeros((2, q.shape[1]))
    spline = _spline_through(times, q, [(1, rest[0]), (2, rest[1])])
    qd, qdd = spline(times, 1), spline(times, 2)
    qd[[0, -1]] = qdd[[0, -1]] = 0.0
    return _trajectory("quintic", times, [q, qd, qdd], name, space)


@np.errstate(all="ignore")
def recorded_trajectory(
    times: FloatArray,
    q: FloatArray,
    qd: FloatArray | None = None,
    qdd: FloatArray | None = None,
    *,
    noise: float | None = None,
    name: str = "recorded",
    space: Space = "joint",
) -> Trajectory:
    """Return a recorded motion as a trajectory.

    Without velocities, the positions, velocities and accelerations are those of a smoothing spline
    of fifth order: the smoothest spline whose residual is within the noise (Reinsch 1967). With
    velocities, the samples are interpolated linearly without smoothing. Missing accelerations are
    then the derivative of a smoothing spline of the velocities.

    Args:
        times: Times of the samples, shape (m,), increasing from 0, in [s].
        q: Positions, shape (m, n), in [rad] or [m].
        qd: Velocities, shape (m, n), in [rad/s] or [m/s], or None.
        qdd: Accelerations, shape (m, n), in [rad/s²] or [m/s²], or None; requires velocities.
        noise: Standard deviation of the noise of the smoothed samples; 0 for a spline through all
            samples (default: estimated for each coordinate).
        space: Whether q contains joint positions or task coordinates.

    Raises:
        InputError: A shape is wrong, a number is out of range, or the times do not increase from 0.
    """
    if noise is not None and not 0.0 <= noise <= _MAX_NOISE:
        raise InputError(f"noise must be between 0 and {_MAX_NOISE:g}, not {noise!r}")
    _require_motion(times, q, 2 if qd is not None and qdd is not None else MIN_SAMPLES)
    for rows in (qd, qdd):
        if rows is not None:
            _require_motion(times, rows, 2)
    if qd is None:
        splines = [_smoothing_spline(times, column, noise) for column in q.T]
        times = _knots(splines)
        smooth = [np.stack([s(times, order) for s in splines], axis=1) for order in range(3)]
        return _trajectory("quintic", times, smooth, name, space)
    if qdd is None:
        splines = [_smoothing_spline(times, column, noise) for column in qd.T]
        qdd = np.stack([spline(times, 1) for spline in splines], axis=1)
    return _trajectory("samples", times, [q, qd, qdd], name, space)


def _smoothing_spline(times: FloatArray, q: FloatArray, noise: float | None) -> BSpline:
    """Return the smoothest spline of fifth order whose residual is consistent with the noise."""
    from scipy.interpolate import BSpline

    m = len(times)
    sigma = _noise(q) if noise is None else noise
    if sigma > 0.0:
        residual = (m + math.sqrt(2.0 * m)) * sigma**2
        knots, c, k = smoothing_spline(times, q, residual)
        if len(knots) - 2 * (k + 1) < _MAX_KNOTS * m:
            return BSpline(knots, c, k)
    return _spline_through(times, q, [(3, 0.0), (4, 0.0)])


def _spline_through(times: FloatArray, q: FloatArray, ends: Any) -> BSpline:
    """Return the spline of fifth order through all samples.

    Args:
        times: Times, shape (m,), in [s].
        q: Samples, shape (m, ...).
        ends: Orders and values of derivatives, equal at both ends.

    Raises:
        InputError: The times are too uneven to compute a spline with floats.
    """
    from scipy.interpolate import make_interp_spline

    try:
        return make_interp_spline(times, q, k=5, bc_type=(ends, ends))
    except (np.linalg.LinAlgError, ValueError):
        steps = np.diff(times)
        raise InputError(
            f"has steps of {steps.min():.3g} to {steps.max():.3g} s, which are too uneven for a "
            "spline"
        ) from None


def _noise(q: FloatArray) -> float:
    """Estimate the standard deviation of the noise from high-order differences.

    The motion vanishes in differences of high order k. The variance of white noise is then
    multiplied by binomial(2k, k).
    """
    orders = [k for k in range(2, _MAX_ORDER + 1) if len(q) >= 3 * k]
    if not orders:
        return 0.0
    mean_squares = (np.mean(np.diff(q, k) ** 2) / math.comb(2 * k, k) for k in orders)
    return max(math.sqrt(min(mean_squares)), _MIN_NOISE * float(np.ptp(q)))


def _knots(splines: Sequence[BSpline]) -> FloatArray:
    """Return the knots of all splines, including the ends, without duplicates."""
    knots: FloatArray = np.unique(np.concatenate([spline.t for spline in splines]))
    distinct: FloatArray = knots[np.diff(knots, prepend=-np.inf) > 1e-9 * knots[-1]]
    return distinct


def _require_motion(times: FloatArray, rows: FloatArray, min_rows: int) -> None:
    """Check shapes, values and times of a motion."""
    if rows.ndim != 2 or len(rows) != len(times):
        raise InputError(f"has shape {rows.shape}, not ({len(times)}, n), for {len(times)} times")
    if len(times) < min_rows:
        raise InputError(f"requires at least {min_rows} rows, not {len(times)}")
    if not (np.isfinite(times).all() and np.isfinite(rows).all()):
        raise InputError("has numbers that are not finite")
    if times[0] != 0.0:
        raise InputError(f"begins at {times[0]:g} s, not at 0")
    steps = np.diff(times)
    if (steps <= 0.0).any():
        k = int(np.argmax(steps <= 0.0))
        raise InputError(f"has a time in row {k + 2} that is not after the time in row {k + 1}")


def _trajectory(
    spline: Spline, times: FloatArray, rows: Sequence[FloatArray], name: str, space: Space
) -> Trajectory:
    if not all(np.isfinite(array).all() for array in rows):
        raise InputError("has a motion too fast for finite velocities and accelerations")
    lists = [[tuple(row) for row in array.tolist()] for array in rows]
    points = tuple(map(TrajectoryPoint, times.tolist(), *lists))
    return Trajectory(name, spline, points, float(times[-1]) / (len(times) - 1), space)
