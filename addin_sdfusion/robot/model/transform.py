"""Rigid transform as a rotation matrix and a translation."""

from __future__ import annotations

from typing import NamedTuple

from .pose import Pose, Vector3
from .rotations import Matrix3, add, multiply, rotate, rpy, subtract, transpose


class Transform(NamedTuple):
    """A rigid transform T_a_b, which takes x to R x + p: from frame b to frame a.

    Attributes:
        R: Rotation matrix, row by row: turns vectors of b into a.
        p: Translation: the origin of b in a, in [m].
    """

    R: Matrix3
    p: Vector3

    def apply(self, point: Vector3) -> Vector3:
        """Return the image of a point, in [m]."""
        return add(self.p, rotate(self.R, point))

    def rotate(self, vector: Vector3) -> Vector3:
        """Return the image of a direction."""
        return rotate(self.R, vector)

    def axis(self, number: int) -> Vector3:
        """Return an axis of b, x 0, y 1 or z 2, in a."""
        return transpose(self.R)[number]

    def compose(self, inner: Transform) -> Transform:
        """T_a_c = T_a_b · T_b_c."""
        return Transform(multiply(self.R, inner.R), self.apply(inner.p))

    def inverse(self) -> Transform:
        """T_b_a."""
        R = transpose(self.R)
        return Transform(R, subtract((0.0, 0.0, 0.0), rotate(R, self.p)))

    def about(self, point: Vector3) -> Transform:
        """Return the same motion, given about the origin, about another point, in [m]."""
        return Transform(self.R, add(self.p, subtract(point, rotate(self.R, point))))

    def pose(self) -> Pose:
        """Return the transform as files hold it: translation, and roll, pitch, yaw."""
        angles = IDENTITY.p if self.R == IDENTITY.R else tidy(rpy(self.R))
        return Pose(tidy(self.p), angles)


IDENTITY = Transform(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))


def tidy(v: Vector3) -> Vector3:
    """Return the vector with 0 in place of -0."""
    return v[0] + 0.0, v[1] + 0.0, v[2] + 0.0
