"""Trajectories from positions alone: through waypoints, and along recorded samples."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.model.trajectory import Space, Spline, Trajectory, TrajectoryPoint
from controllers.arrays import FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

_MAX_NOISE = 1e100  # whose square is a number

MIN_SAMPLES = 6
"""That a smoothing spline needs."""

_MAX_KNOTS = 0.75  # a sample; with more, samples are too far apart to tell noise from motion
_MAX_ORDER = 12
_MIN_NOISE = 1e-9  # of the largest difference: below it, the spline's knots are rounding's


@np.errstate(all="ignore")  # what overflows is rejected at the end
def waypoint_trajectory(
    times: FloatArray, q: FloatArray, name: str = "waypoints", space: Space = "joint"
) -> Trajectory:
    """The motion of least jerk through waypoints, from rest to rest, without stopping on the way.

    It minimises the integral of the squared third derivative: a spline of fifth order whose
    derivatives up to the fourth are continuous.

    Args:
        times: Of the waypoints, shape (m,), m >= 2, rising from 0, in [s].
        q: Positions, shape (m, n), in [rad] or [m].
        name: The trajectory's name.
        space: Whether q is joint positions or task coordinates.

    Raises:
        InputError: Shapes, numbers or times are none of a motion.
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

    Without velocities, a smoothing spline of fifth order gives positions, velocities and
    accelerations: the smoothest that stays within the noise (Reinsch 1967). What is given is taken
    as it is and interpolated linearly; accelerations that are missing are the derivative of the
    velocities' smoothing spline.

    Args:
        times: Of the samples, shape (m,), rising from 0, in [s].
        q: Positions, shape (m, n), in [rad] or [m].
        qd: Velocities, shape (m, n).
        qdd: Accelerations, shape (m, n); with velocities only.
        noise: Standard deviation of the noise in what is smoothed; 0 for a spline through all
            samples; found from the samples, for each coordinate, when None.
        name: The trajectory's name.
        space: Whether q is joint positions or task coordinates.

    Raises:
        InputError: Shapes, numbers or times are none of a motion, or the noise is none.
    """
    if noise is not None and not 0.0 <= noise <= _MAX_NOISE:
        raise InputError(f"noise must be within 0 and {_MAX_NOISE:g}, not {noise!r}")
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
    """Return the smoothest spline of fifth order whose squared distances sum up as noise's do."""
    from scipy.interpolate import BSpline, splrep

    m = len(times)
    sigma = _noise(q) if noise is None else noise
    if sigma > 0.0:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # its last spline is good enough
            knots, c, k = splrep(times, q, k=5, s=(m + math.sqrt(2.0 * m)) * sigma**2)
        if len(knots) - 2 * (k + 1) < _MAX_KNOTS * m:
            return BSpline(knots, c, k)
    return _spline_through(times, q, [(3, 0.0), (4, 0.0)])


def _spline_through(times: FloatArray, q: FloatArray, ends: Any) -> BSpline:
    """Return the spline of fifth order through all samples.

    Args:
        times: Shape (m,).
        q: Shape (m, ...).
        ends: Orders of derivatives with their values, the same at both ends.

    Raises:
        InputError: Times are so uneven that rounding leaves no spline.
    """
    from scipy.interpolate import make_interp_spline

    try:
        return make_interp_spline(times, q, k=5, bc_type=(ends, ends))
    except (np.linalg.LinAlgError, ValueError):
        steps = np.diff(times)
        what = f"has times {steps.min():.3g} to {steps.max():.3g} s apart, too uneven for a spline"
        raise InputError(what) from None


def _noise(q: FloatArray) -> float:
    """The noise's standard deviation, by differences of an order in which the motion vanishes.

    Differences of order k have the variance binomial(2k, k) times that of white noise.
    """
    orders = [k for k in range(2, _MAX_ORDER + 1) if len(q) >= 3 * k]
    if not orders:
        return 0.0
    mean_squares = (np.mean(np.diff(q, k) ** 2) / math.comb(2 * k, k) for k in orders)
    return max(math.sqrt(min(mean_squares)), _MIN_NOISE * float(np.ptp(q)))


def _knots(splines: Sequence[BSpline]) -> FloatArray:
    """Where polynomials of any of the splines meet, ends included."""
    every: FloatArray = np.unique(np.concatenate([spline.t for spline in splines]))
    kept: FloatArray = every[np.diff(every, prepend=-np.inf) > 1e-9 * every[-1]]
    return kept


def _require_motion(times: FloatArray, rows: FloatArray, fewest: int) -> None:
    """Reject what is not a motion."""
    if rows.ndim != 2 or len(rows) != len(times):
        raise InputError(f"has no row for each of {len(times)} times: shape {rows.shape}")
    if len(times) < fewest:
        raise InputError(f"needs at least {fewest} rows, not {len(times)}")
    if not (np.isfinite(times).all() and np.isfinite(rows).all()):
        raise InputError("has numbers that are not finite")
    if times[0] != 0.0:
        raise InputError(f"begins at {times[0]:g} s, not at 0")
    steps = np.diff(times)
    if (steps <= 0.0).any():
        k = int(np.argmax(steps <= 0.0))
        raise InputError(f"the time of row {k + 2} is not after that of the row before")


def _trajectory(
    spline: Spline, times: FloatArray, rows: Sequence[FloatArray], name: str, space: Space
) -> Trajectory:
    if not all(np.isfinite(each).all() for each in rows):
        raise InputError("has a motion too fast for finite velocities and accelerations")
    lists = [[tuple(row) for row in each.tolist()] for each in rows]
    points = tuple(map(TrajectoryPoint, times.tolist(), *lists))
    return Trajectory(name, spline, points, float(times[-1]) / (len(times) - 1), space)
