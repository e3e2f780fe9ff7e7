"""Points along geodesics of ellipsoids, for drawing."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sim_dart.core.arrays import FloatArray

_STEP = 0.1
"""Distance of drawn points, relative to the shortest half axis."""
_MAX_STEPS = 200
_MISS = 1e-3
"""Largest error of the end of a geodesic, relative to the shortest half axis."""


class PlacedEllipsoid(NamedTuple):
    """An ellipsoid with its pose in the world.

    Attributes:
        centre: Position of its centre in the world, shape (3,), in [m].
        R_world_ellipsoid: Rotation matrix with its axes as columns, shape (3, 3).
        half_axes: Half axes along x, y and z, shape (3,), in [m].
    """

    centre: FloatArray
    R_world_ellipsoid: FloatArray
    half_axes: FloatArray


def geodesic_line(
    ellipsoid: PlacedEllipsoid,
    touch: FloatArray,
    lift: FloatArray,
    direction: FloatArray,
    length: float,
) -> list[FloatArray]:
    """Return points along a geodesic, including both ends, in the world frame.

    Args:
        touch: Start point, shape (3,), in [m]. A point inside of the ellipsoid shrinks it.
        lift: End point, shape (3,), in [m].
        direction: Direction at the start, a unit vector, shape (3,).
        length: Length of the geodesic, in [m].
    """
    R, least = ellipsoid.R_world_ellipsoid, float(ellipsoid.half_axes.min())
    steps = min(_MAX_STEPS, max(1, math.ceil(length / (_STEP * least))))
    begin, end = R.T @ (touch - ellipsoid.centre), R.T @ (lift - ellipsoid.centre)
    r = ellipsoid.half_axes * np.linalg.norm(begin / ellipsoid.half_axes)
    points = _integrate_geodesic(r, begin, R.T @ direction, length / steps, steps)
    if np.linalg.norm(points[-1] - end) > _MISS * least:
        points = _central_projection(r, begin, end, steps)
    return [touch, *(ellipsoid.centre + R @ point for point in points[:-1]), lift]


def _integrate_geodesic(
    r: FloatArray, x: FloatArray, v: FloatArray, h: float, steps: int
) -> list[FloatArray]:
    """Integrate x'' = -(v'Av) / |Ax|^2 Ax with A = diag(1/r^2) by the Runge-Kutta method."""
    A, points = 1.0 / (r * r), []

    def bend(x: FloatArray, v: FloatArray) -> FloatArray:
        n = A * x
        bent: FloatArray = -float(v @ (A * v)) / float(n @ n) * n
        return bent

    for _ in range(steps):
        k1, v2 = bend(x, v), v + 0.5 * h * bend(x, v)
        k2 = bend(x + 0.5 * h * v, v2)
        v3 = v + 0.5 * h * k2
        k3 = bend(x + 0.5 * h * v2, v3)
        v4 = v + h * k3
        k4 = bend(x + h * v3, v4)
        x = x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v = v + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        points.append(x)
    return points


def _central_projection(
    r: FloatArray, begin: FloatArray, end: FloatArray, steps: int
) -> list[FloatArray]:
    a, b = begin / r, end / r
    mixed = [a + (b - a) * k / steps for k in range(1, steps + 1)]
    return [r * point / np.linalg.norm(point) for point in mixed]
