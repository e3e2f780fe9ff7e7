"""Spline references: piecewise polynomials through given points, as defined by CASPR."""

from __future__ import annotations

import math
from collections.abc import Sequence
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
    times = [point.time for point in points]
    lengths = np.diff(times)
    derivatives = [np.array([row for row in (p.q, p.qd, p.qdd) if len(row)]) for p in points]
    orders = max(len(before) + len(after) for before, after in pairwise(derivatives))
    bernstein = np.array(
        [
            _raise_degree(_bernstein(before, after, length), orders)
            for (before, after), length in zip(pairwise(derivatives), lengths, strict=True)
        ]
    )
    return times, _with_derivatives(_powers(bernstein, lengths))


def _bernstein(before: FloatArray, after: FloatArray, length: float) -> FloatArray:
    """Return the polynomial with given values and derivatives at both ends, in Bernstein form.

    The q-th derivative at an end only depends on the q + 1 coefficients nearest to that end.

    Args:
        before: Value and derivatives at the start, shape (1 to 3, n).
        after: Value and derivatives at the end, shape (1 to 3, n).
        length: Time between start and end, in [s].

    Returns:
        Coefficients, shape (len(before) + len(after), n).
    """
    count = len(before) + len(after)
    c = np.empty((count, before.shape[1]))
    for q, row in enumerate(before):
        c[q] = row / math.perm(count - 1, q) * length**q
        for j in range(q):
            c[q] -= (-1) ** (j + q) * math.comb(q, j) * c[j]
    for q, row in enumerate(after):
        c[-q - 1] = row / math.perm(count - 1, q) * (-1) ** q * length**q
        for j in range(q):
            c[-q - 1] -= (-1) ** (j + 1) * math.comb(q, j + 1) * c[-q + j]
    return c


def _raise_degree(c: FloatArray, orders: int) -> FloatArray:
    """Return the same polynomial in Bernstein form with more coefficients."""
    degree, more = len(c) - 1, orders - len(c)
    if not more:
        return c
    raised = np.zeros((orders, c.shape[1]))
    for a in range(len(c)):
        for j in range(more + 1):
            term = c[a] * math.comb(degree, a) * math.comb(more, j)
            raised[a + j] += term / math.comb(degree + more, a + j)
    return raised


def _powers(bernstein: FloatArray, lengths: FloatArray) -> FloatArray:
    """Convert Bernstein form to powers of time, lowest first, shape (segments, orders, n)."""
    degree = bernstein.shape[1] - 1
    powers = np.zeros_like(bernstein)
    for a in range(degree + 1):
        factor = (-1) ** a * math.comb(degree, a) * bernstein[:, a]
        for s in range(a, degree + 1):
            weight = math.comb(degree - a, s - a) * (-1) ** s
            powers[:, s] += factor * weight / lengths[:, None] ** s
    return powers


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
