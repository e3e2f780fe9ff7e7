"""Rotations, poses and inertia matrices as plain tuples.

A rotation is a matrix, given by rows, that transforms vectors from the child to the parent frame.
"""

from __future__ import annotations

import math
import sys

from .pose import Pose, Vector3

Matrix3 = tuple[Vector3, Vector3, Vector3]

_LARGE = 2.0**200
UNIT_TOLERANCE = 1e-12
"""A vector whose norm differs from one by at most this value is considered a unit vector."""


def rotation(rpy: Vector3) -> Matrix3:
    """Return the rotation matrix R = Rz(yaw) Ry(pitch) Rx(roll).

    Args:
        rpy: Roll, pitch and yaw, in [rad].
    """
    (cr, cp, cy), (sr, sp, sy) = map(math.cos, rpy), map(math.sin, rpy)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def axis_rotation(axis: Vector3, angle: float) -> Matrix3:
    """Return the rotation matrix about an axis; exactly the identity for the angle 0.

    Args:
        axis: Unit vector.
        angle: In [rad].
    """
    x, y, z = axis
    c, s = math.cos(angle), math.sin(angle)
    d = 1.0 - c
    return (
        (c + d * x * x, d * x * y - s * z, d * x * z + s * y),
        (d * y * x + s * z, c + d * y * y, d * y * z - s * x),
        (d * z * x - s * y, d * z * y + s * x, c + d * z * z),
    )


def rpy(R: Matrix3) -> Vector3:
    """Return roll, pitch and yaw of a rotation matrix, in [rad], with pitch within ±π/2.

    The yaw is computed after the roll is removed. Therefore the three angles reproduce R even if
    roll and yaw rotate about the same axis.
    """
    roll = math.atan2(R[2][1], R[2][2])
    pitch = math.atan2(-R[2][0], math.hypot(R[0][0], R[1][0]))
    sr, cr = math.sin(roll), math.cos(roll)
    yaw = math.atan2(sr * R[0][2] - cr * R[0][1], cr * R[1][1] - sr * R[1][2])
    return roll, pitch, yaw


def z_axis_rpy(axis: Vector3) -> Vector3:
    """Return roll, pitch and yaw of a frame whose z axis is along a vector, in [rad]."""
    x, y, z = axis  # (sin pitch cos yaw, sin pitch sin yaw, cos pitch) times its length
    return 0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x) if x or y else 0.0


def transpose(A: Matrix3) -> Matrix3:
    """Return Aᵀ, the inverse of a rotation."""
    (a, b, c), (d, e, f), (g, h, i) = A
    return (a, d, g), (b, e, h), (c, f, i)


def rotate(A: Matrix3, v: Vector3) -> Vector3:
    """Return the product A v."""
    return dot(A[0], v), dot(A[1], v), dot(A[2], v)


def multiply(A: Matrix3, B: Matrix3) -> Matrix3:
    """Return the product A B."""
    return transpose((rotate(A, _column(B, 0)), rotate(A, _column(B, 1)), rotate(A, _column(B, 2))))


def dot(a: Vector3, b: Vector3) -> float:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector3, b: Vector3) -> Vector3:
    """Return the vector product a × b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def add(a: Vector3, b: Vector3) -> Vector3:
    """Return the sum a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Vector3, b: Vector3) -> Vector3:
    """Return the difference a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(factor: float, v: Vector3) -> Vector3:
    """Return the vector times a factor."""
    return factor * v[0], factor * v[1], factor * v[2]


def perpendicular(v: Vector3, axis: Vector3) -> Vector3:
    """Return the component of a vector perpendicular to a unit vector."""
    return subtract(v, scale(dot(v, axis), axis))


def quaternion_rotation(w: float, x: float, y: float, z: float) -> Matrix3:
    """Return the rotation matrix of a unit quaternion."""
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


def normalized(v: Vector3) -> Vector3:
    """Return the unit vector along v; return v if it is a unit vector or has no direction."""
    norm = math.hypot(*v)
    if norm == 0.0 or not math.isfinite(norm) or abs(norm - 1.0) <= UNIT_TOLERANCE:
        return v
    if norm < sys.float_info.min:  # a subnormal norm is too inaccurate for a division
        return normalized(scale(_LARGE, v))
    return v[0] / norm, v[1] / norm, v[2] / norm


def compose(T_a_b: Pose, T_b_c: Pose) -> Pose:
    """Return T_a_c = T_a_b · T_b_c. If one of them does not rotate, use the other's angles."""
    position = apply(T_a_b, T_b_c.position)
    if not any(T_a_b.rpy):
        return Pose(position, T_b_c.rpy)
    if not any(T_b_c.rpy):
        return Pose(position, T_a_b.rpy)
    return Pose(position, rpy(multiply(rotation(T_a_b.rpy), rotation(T_b_c.rpy))))


def inverse(T_a_b: Pose) -> Pose:
    """Return T_b_a; it is exact if T_a_b does not rotate."""
    R_b_a = transpose(rotation(T_a_b.rpy))
    x, y, z = rotate(R_b_a, T_a_b.position)
    return Pose((-x, -y, -z), rpy(R_b_a) if any(T_a_b.rpy) else T_a_b.rpy)


def apply(T_a_b: Pose, p_b: Vector3) -> Vector3:
    """Return the point p_b of frame b, expressed in frame a, in [m]."""
    if not any(T_a_b.rpy):
        return add(T_a_b.position, p_b)
    return add(T_a_b.position, rotate(rotation(T_a_b.rpy), p_b))


def rotate_inertia(R_a_b: Matrix3, inertia_b: Matrix3) -> Matrix3:
    """Transform an inertia matrix from the axes of b to the axes of a: R I Rᵀ, in [kg·m²]."""
    return multiply(multiply(R_a_b, inertia_b), transpose(R_a_b))


def point_inertia(mass: float, r: Vector3) -> Matrix3:
    """Return the inertia of a point mass at r about the origin: m (rᵀr 1 - r rᵀ), in [kg·m²].

    By the parallel-axis theorem this is also the difference between an inertia matrix about a point
    at a distance r from the centre of mass and the matrix about the centre of mass.

    Args:
        mass: In [kg].
        r: Position, in [m].
    """
    x, y, z = r
    return (
        (mass * (y * y + z * z), -mass * x * y, -mass * x * z),
        (-mass * x * y, mass * (x * x + z * z), -mass * y * z),
        (-mass * x * z, -mass * y * z, mass * (x * x + y * y)),
    )


def _column(A: Matrix3, j: int) -> Vector3:
    return A[0][j], A[1][j], A[2][j]
