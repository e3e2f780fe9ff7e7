"""Conversion of Fusion's points, vectors and matrices to plain tuples in SI units.

Fusion uses cm for lengths, rad for angles, kg for masses and kg·cm² for moments of inertia.
"""

from __future__ import annotations

import math
from typing import Any

from ..robot.model.pose import Vector3
from ..robot.model.rotations import cross, dot, normalized, transpose
from ..robot.model.transform import Transform

CM = 0.01
"""One cm, in [m]."""

KG_CM2 = 1e-4
"""One kg·cm², in [kg·m²]."""

NEAR = 1e-5
"""Tolerance of equal positions, in [m]; Fusion's tolerance is 1e-8 m."""

PARALLEL = 1e-6
"""Tolerance of equal unit vectors."""


def finite(value: float) -> float:
    """Return a value if it is finite.

    Raises:
        ValueError: The value is infinite or NaN.
    """
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"Fusion returned {number}, which is not finite")
    return number


def length(cm: float) -> float:
    """Return a length given in cm, in [m]."""
    return finite(cm) * CM


def position(point: Any) -> Vector3:
    """Return the coordinates of a Point3D or Vector3D, in [m]."""
    return length(point.x), length(point.y), length(point.z)


def direction(vector: Any) -> Vector3:
    """Return the unit vector along a Vector3D.

    Raises:
        ValueError: The vector is missing or zero.
    """
    if vector is None:
        raise ValueError("Fusion returned no direction")
    unit = normalized((finite(vector.x), finite(vector.y), finite(vector.z)))
    if not any(unit):
        raise ValueError("the direction is a zero vector")
    return unit


def frame(matrix: Any) -> Transform:
    """Return the transform of a Matrix3D, which has sixteen numbers in row-major order."""
    m = [finite(value) for value in matrix.asArray()]
    R = ((m[0], m[1], m[2]), (m[4], m[5], m[6]), (m[8], m[9], m[10]))
    return Transform(R, (m[3] * CM, m[7] * CM, m[11] * CM))


def axes_frame(origin: Vector3, x: Any, y: Any, z: Any) -> Transform:
    """Return the frame with an origin, in [m], and three Vector3D as axes."""
    return Transform(transpose((direction(x), direction(y), direction(z))), origin)


def is_rigid(T: Transform) -> bool:
    """Return whether a frame is neither mirrored nor scaled."""
    x, y, z = transpose(T.R)
    units = all(abs(math.hypot(*v) - 1.0) <= PARALLEL for v in (x, y, z))
    square = max(abs(dot(x, y)), abs(dot(y, z)), abs(dot(z, x))) <= PARALLEL
    return units and square and dot(x, cross(y, z)) > 0.0


def near(a: Vector3, b: Vector3) -> bool:
    """Return whether two points coincide."""
    return math.dist(a, b) <= NEAR


def chord(a: Vector3, b: Vector3) -> float:
    """Return the chord length between two unit vectors without regard to their sign."""
    return min(math.dist(a, b), math.dist(a, (-b[0], -b[1], -b[2])))


def parallel(a: Vector3, b: Vector3) -> bool:
    """Return whether two unit vectors are parallel or antiparallel."""
    return chord(a, b) <= PARALLEL
