"""Fusion's points, vectors and matrices as plain tuples in SI units: cm become m here.

Fusion counts lengths in cm, angles in rad, masses in kg, moments of inertia in kg·cm².
"""

from __future__ import annotations

import math
from typing import Any

from ..robot.model.pose import Vector3
from ..robot.model.rotations import cross, dot, normalized, subtract, transpose
from ..robot.model.transform import Transform

CM = 0.01
"""One cm, in [m]."""

KG_CM2 = 1e-4
"""One kg·cm², in [kg·m²]."""

NEAR = 1e-5
"""Positions that differ by less count as one, in [m]; Fusion's own tolerance is 1e-8 m."""

PARALLEL = 1e-6
"""Unit vectors that differ by less count as one."""


def finite(value: float) -> float:
    """Return a finite number.

    Raises:
        ValueError: It is infinite or no number.
    """
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"Fusion returned {number}, which is not finite")
    return number


def length(cm: float) -> float:
    """Return a length, in [m]."""
    return finite(cm) * CM


def position(point: Any) -> Vector3:
    """Return a Point3D, or a Vector3D that leads to a point, in [m]."""
    return length(point.x), length(point.y), length(point.z)


def direction(vector: Any) -> Vector3:
    """Return the unit vector along a Vector3D.

    Raises:
        ValueError: There is none, or it has no direction.
    """
    if vector is None:
        raise ValueError("Fusion gives no direction")
    found = normalized((finite(vector.x), finite(vector.y), finite(vector.z)))
    if not any(found):
        raise ValueError("the direction has no length")
    return found


def frame(matrix: Any) -> Transform:
    """Return a Matrix3D, whose sixteen numbers go row by row."""
    m = [finite(value) for value in matrix.asArray()]
    R = ((m[0], m[1], m[2]), (m[4], m[5], m[6]), (m[8], m[9], m[10]))
    return Transform(R, (m[3] * CM, m[7] * CM, m[11] * CM))


def axes_frame(origin: Vector3, x: Any, y: Any, z: Any) -> Transform:
    """Return the frame of an origin, in [m], and three Vector3D along its axes."""
    return Transform(transpose((direction(x), direction(y), direction(z))), origin)


def is_rigid(T: Transform) -> bool:
    """Return whether a frame is neither mirrored nor scaled."""
    x, y, z = transpose(T.R)
    units = all(abs(math.hypot(*v) - 1.0) <= PARALLEL for v in (x, y, z))
    square = max(abs(dot(x, y)), abs(dot(y, z)), abs(dot(z, x))) <= PARALLEL
    return units and square and dot(x, cross(y, z)) > 0.0


def distance(a: Vector3, b: Vector3) -> float:
    """How far two points are apart, in [m]."""
    return math.hypot(*subtract(a, b))


def near(a: Vector3, b: Vector3) -> bool:
    """Return whether two points are one."""
    return distance(a, b) <= NEAR


def parallel(a: Vector3, b: Vector3) -> bool:
    """Return whether two unit vectors lie along one line, whichever way they point."""
    return min(distance(a, b), distance(a, (-b[0], -b[1], -b[2]))) <= PARALLEL
