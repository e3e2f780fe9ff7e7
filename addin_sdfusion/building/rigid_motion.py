"""Rigid motions as a rotation matrix and a translation, and those that joints make."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from ..robot.model.pose import Pose, Vector3
from ..robot.model.rotations import (
    Matrix3,
    add,
    axis_rotation,
    multiply,
    rotate,
    rpy,
    subtract,
    transpose,
)
from ..snapshot import MotionSnapshot


class RigidMotion(NamedTuple):
    """x becomes R x + p.

    Attributes:
        R: Rotation, row by row.
        p: Translation, in [m].
    """

    R: Matrix3
    p: Vector3


AT_REST = RigidMotion(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))


def moved(T: RigidMotion, point: Vector3) -> Vector3:
    """Where the motion takes a point, in [m]."""
    return add(rotate(T.R, point), T.p)


def followed(first: RigidMotion, second: RigidMotion) -> RigidMotion:
    """The first motion, then the second: second · first as matrices."""
    return RigidMotion(multiply(second.R, first.R), moved(second, first.p))


def undone(T: RigidMotion) -> RigidMotion:
    """The motion back."""
    R = transpose(T.R)
    return RigidMotion(R, subtract((0.0, 0.0, 0.0), rotate(R, T.p)))


def about(point: Vector3, T: RigidMotion) -> RigidMotion:
    """The same motion, given about the origin, about another point.

    Args:
        point: In [m].
        T: The motion.
    """
    return RigidMotion(T.R, add(T.p, subtract(point, rotate(T.R, point))))


def joint_motion(motions: Iterable[MotionSnapshot]) -> RigidMotion:
    """Where a joint at the origin stands: m_1 · m_2 · ... of its motions.

    Args:
        motions: In their order, with axes as the body has them that does not move.
    """
    T = AT_REST
    for motion in motions:
        if motion.kind == "rotation":
            step = RigidMotion(axis_rotation(motion.axis, motion.value), AT_REST.p)
        else:
            x, y, z = motion.axis
            step = RigidMotion(AT_REST.R, (motion.value * x, motion.value * y, motion.value * z))
        T = followed(step, T)
    return T


def pose(T: RigidMotion) -> Pose:
    """The motion as a pose."""
    return Pose(tidy(T.p), tidy(rpy(T.R)) if T.R != AT_REST.R else AT_REST.p)


def tidy(v: Vector3) -> Vector3:
    """The vector with 0 in place of -0, which reads like a mistake in a file."""
    return v[0] + 0.0, v[1] + 0.0, v[2] + 0.0
