"""Rigid transform with a rotation matrix and a translation."""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from typing import Literal, NamedTuple

from .pose import AXES, Pose, Vector3
from .rotations import (
    Matrix3,
    add,
    axis_rotation,
    multiply,
    rotate,
    rotation,
    rpy,
    scale,
    subtract,
    transpose,
)


class Transform(NamedTuple):
    """A rigid transform T_a_b, which maps x in frame b to R x + p in frame a.

    Attributes:
        R: Rows of the rotation matrix R_a_b.
        p: Translation: the origin of b in a, in [m].
    """

    R: Matrix3
    p: Vector3

    @staticmethod
    def of(pose: Pose) -> Transform:
        """Return a pose as a transform."""
        return Transform(rotation(pose.rpy), pose.position)

    def apply(self, point: Vector3) -> Vector3:
        """Transform a point, in [m]."""
        return add(self.p, rotate(self.R, point))

    def apply_all(self, coordinates: Iterable[float]) -> array[float]:
        """Transform points x, y, z, x, y, z, ..., in [m]."""
        (a, b, c), (d, e, f), (g, h, i) = self.R
        u, v, w = self.p
        moved, rest = array("d"), iter(coordinates)
        for x, y, z in zip(rest, rest, rest, strict=True):
            moved.append(a * x + b * y + c * z + u)
            moved.append(d * x + e * y + f * z + v)
            moved.append(g * x + h * y + i * z + w)
        return moved

    def rotate(self, vector: Vector3) -> Vector3:
        """Rotate a direction."""
        return rotate(self.R, vector)

    def axis(self, number: int) -> Vector3:
        """Return an axis of b (0 for x, 1 for y, 2 for z) in a."""
        return transpose(self.R)[number]

    def compose(self, inner: Transform) -> Transform:
        """Return T_a_c = T_a_b · T_b_c."""
        return Transform(multiply(self.R, inner.R), self.apply(inner.p))

    def inverse(self) -> Transform:
        """Return the inverse T_b_a."""
        R = transpose(self.R)
        return Transform(R, subtract((0.0, 0.0, 0.0), rotate(R, self.p)))

    def about(self, point: Vector3) -> Transform:
        """Return the transform with its rotation about a point, in [m], instead of the origin."""
        return Transform(self.R, add(self.p, subtract(point, rotate(self.R, point))))

    def pose(self) -> Pose:
        """Return the transform as a pose: translation, and roll, pitch, yaw."""
        angles = IDENTITY.p if self.R == IDENTITY.R else tidy(rpy(self.R))
        return Pose(tidy(self.p), angles)


IDENTITY = Transform(AXES, (0.0, 0.0, 0.0))


def motion_transform(
    kind: Literal["rotation", "translation"], axis: Vector3, value: float
) -> Transform:
    """Return the transform of a motion about or along an axis.

    Args:
        axis: Unit vector.
        value: In [rad] or [m].
    """
    if kind == "rotation":
        return Transform(axis_rotation(axis, value), IDENTITY.p)
    return Transform(IDENTITY.R, scale(value, axis))


def tidy(v: Vector3) -> Vector3:
    """Return the vector with 0 instead of -0."""
    return v[0] + 0.0, v[1] + 0.0, v[2] + 0.0
