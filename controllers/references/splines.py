"""Spline references: piecewise polynomials through given points, as defined by CASPR."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from itertools import pairwise

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.model.trajectory import Trajectory, TrajectoryPoint
from controllers.arrays import FloatArray

from .reference import SPLINES, Reference, ReferencePart


class SplineReference(Reference):
    """Piecewise polynomial through the points of a trajectory, separate for every coordinate.

    A linear spline matches positions. A cubic spline (Hermite) also matches velocities, and a
    quintic spline also matches accelerations. A parabolic blend is at rest at every point. Between
    two points it accelerates for the blend time, moves at constant velocity, and decelerates for
    the blend time. Between samples, positions, velocities and accelerations are interpolated
    linearly and separately, since polynomials through rounded samples oscillate.

    The reference is at rest before the first point and after the last point.

    Args:
        trajectory: The points. In an operational trajectory, q contains y.

    Attributes:
        name: Name of the trajectory.
        duration: Time of the last point, in [s].
        times: Start times of the segments and end time of the last one, in [s].
        coefficients: Polynomial coefficients of positions, velocities and accelerations, shape
            (segments, powers, 3, n). The variable is the time since the start of the segment;
            the lowest power is first.

    Raises:
        InputError: The motion between two points exceeds the range of floats.
    """

    @np.errstate(all="ignore")  # values that overflow are rejected at the end
    def __init__(self, trajectory: Trajectory) -> None:
        points = trajectory.points
        if trajectory.spline == "samples":
            self.times, coefficients = _through_samples(points)
        elif trajectory.spline == "parabolic_blend":
            self.times, coefficients = _blends(points)
        else:
            self.times, coefficients = _splines(points)
        if not np.isfinite(coefficients).all():
            segment = int((~np.isfinite(coefficients)).any(axis=(1, 2, 3)).argmax())
            raise InputError(
                f"trajectory {trajectory.name!r} is too fast after {self.times[segment]:.6g} s: "
                "the points are too far apart for the time between them; increase the time"
            )
        self.coefficients = coefficients
        data = np.concatenate([self.times, coefficients.ravel(), points[0].q, points[-1].q])
        segments, powers, _, n = coefficients.shape
        part = ReferencePart(SPLINES, n, points[-1].time, segments, powers, data)
        super().__init__(trajectory.name, [part])


def _splines(points: Sequence[TrajectoryPoint]) -> tuple[list[float], FloatArray]:
    """Return segments that match the positions and derivatives of the points.

    Returns:
        Start times of the segments and end time of the last one, in [s], and coefficients of
        positions, velocities and accelerations, shape (segments, orders, 3, n), as in
        `SplineReference.coefficients`.
    """
    derivatives = [np.array([row for row in (p.q, p.qd, p.qdd) if len(row)]) for p in points]
    orders = max(len(before) + len(after) for before, after in pairwise(derivatives))
    times = [point.time for point in points]
    segments = np.zeros((len(points) - 1, orders, len(points[0].q)))
    for c, ends, length in zip(segments, pairwise(derivatives), np.diff(times), strict=True):
        scales = np.cumprod([1.0, *[length] * (orders - 1)])
        at_ends = np.concatenate([end * scales[: len(end), None] for end in ends])
        M = _hermite(*map(len, ends))
        c[: len(M)] = (M[:, :, None] * at_ends).sum(axis=1) / scales[: len(M), None]
    return times, _with_derivatives(segments)


@cache
def _hermite(before: int, after: int) -> FloatArray:
    """Return the matrix from values and derivatives at the ends to the coefficients of u^0, u^1...

    Args:
        before: Number of values and derivatives at u = 0, 1 to 3.
        after: The same at u = 1.
    """
    powers = range(before + after)
    rows = [[math.perm(k, q) * float(k == q) for k in powers] for q in range(before)]
    rows += [[float(math.perm(k, q)) for k in powers] for q in range(after)]
    M: FloatArray = np.rint(2.0 * np.linalg.inv(rows)) / 2.0
    return M  # exact, since all entries are multiples of 1/2


def _blends(points: Sequence[TrajectoryPoint]) -> tuple[list[float], FloatArray]:
    """Return a parabola, a line and a parabola between each two points; see `_splines`."""
    times, segments = [0.0], []
    for start, end in pairwise(points):
        q0, q1 = np.array(start.q), np.array(end.q)
        blend, duration = end.blend_time, end.time - start.time
        a = (q1 - q0) / (blend * (duration - blend))
        v, shift = a * blend, a * blend**2 / 2.0
        segments += [(q0, 0.0 * a, a / 2.0), (q0 + shift, v, 0.0 * a), (q1 - shift, v, -a / 2.0)]
        times += [start.time + blend, end.time - blend, end.time]
    return times, _with_derivatives(np.array(segments))


def _with_derivatives(coefficients: FloatArray) -> FloatArray:
    """Return coefficients of polynomials and of their first and second derivatives.

    Args:
        coefficients: Coefficients, lowest order first, shape (segments, orders, n).

    Returns:
        Coefficients of values and derivatives, shape (segments, orders, 3, n).
    """
    table = np.zeros((*coefficients.shape[:2], 3, coefficients.shape[2]))
    k = np.arange(1, coefficients.shape[1])[:, None]
    table[:, :, 0] = coefficients
    table[:, :-1, 1] = k * table[:, 1:, 0]
    table[:, :-1, 2] = k * table[:, 1:, 1]
    return table


def _through_samples(points: Sequence[TrajectoryPoint]) -> tuple[list[float], FloatArray]:
    """Return linear segments of q, qd and qdd between each two samples; see `_splines`."""
    times = [point.time for point in points]
    rows = np.array([(p.q, p.qd, p.qdd) for p in points])
    slopes = np.diff(rows, axis=0) / np.diff(times)[:, None, None]
    return times, np.stack([rows[:-1], slopes], axis=1)
