"""Axes of joints in the root frame, signed so that a value moves `one` relative to `two`.

An axis is that on `two`: the direction that it has in the root frame at the pose of `two`, when the
motions before it in the joint are at zero. It is given as a vector, and as the number of an axis of
the joint's geometry; where these contradict each other the vector was not in the root frame.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ...robot.model.pose import Vector3
from ...robot.model.rotations import (
    Matrix3,
    axis_rotation,
    cross,
    dot,
    multiply,
    rotate,
    subtract,
    transpose,
)
from ...robot.model.transform import IDENTITY, Transform
from ...snapshot import MotionSnapshot
from ..units import NEAR, PARALLEL, parallel
from .frames import JointFrames
from .motions import CUSTOM, Freedom, reversed_axis


def in_root(
    freedoms: Sequence[Freedom], frames: JointFrames, others: Sequence[Transform]
) -> tuple[Freedom, ...] | None:
    """The freedoms with axes in the root frame; None if their axes contradict the geometry.

    Args:
        freedoms: As read through the joint's proxy: in the root frame.
        frames: Of the joint.
        others: Poses of the frames that they may be given in instead.
    """
    for T in (IDENTITY, *others):
        turned = tuple(
            Freedom(replace(f.motion, axis=T.rotate(f.motion.axis)), f.along) for f in freedoms
        )
        if all(_fits(freedom, frames) for freedom in turned):
            return turned
    return None


def _fits(freedom: Freedom, frames: JointFrames) -> bool:
    sides = [side for side in (frames.two, frames.one) if side is not None]
    # Yaw and roll of a ball joint may be carried by the motions before them: see `ball_axes`.
    if freedom.along not in (0, 1, 2) or not sides or freedom.motion.role == "yaw":
        return True
    return any(parallel(freedom.motion.axis, side.axis(freedom.along)) for side in sides)


def signed(motions: Sequence[MotionSnapshot], frames: JointFrames) -> tuple[MotionSnapshot, ...]:
    """The motions of a joint without offsets, an axis reversed where its value says so.

    How `one` is placed on `two` is known from the joint's frames. If it is exactly how the values
    would place it the other way round, the axis is reversed.
    """
    if frames.one is None or frames.two is None:
        return tuple(motions)
    turned = multiply(frames.one.R, transpose(frames.two.R))
    moved = subtract(frames.one.p, frames.two.p)
    return tuple(_signed(motion, turned, moved) for motion in motions)


def _signed(motion: MotionSnapshot, turned: Matrix3, moved: Vector3) -> MotionSnapshot:
    back = replace(motion, axis=reversed_axis(motion.axis))
    if motion.kind == "translation":
        along = dot(moved, motion.axis)
        wrong = abs(along + motion.value) <= NEAR < abs(along - motion.value)
        return back if wrong else motion
    wrong = _same(turned, _turn(back)) and not _same(turned, _turn(motion))
    return back if wrong else motion


def ball_axes(
    motions: Sequence[MotionSnapshot], yaw_along: int, frames: JointFrames
) -> tuple[tuple[MotionSnapshot, ...], bool]:
    """Pitch, yaw and roll with axes as on `two`, and whether it is certain that they are.

    It is not documented whether Fusion gives the axes of a ball joint as they are on `two`, or each
    as the rotations before it have carried it. Three things decide: the yaw axis is the geometry's
    x axis unless the user chose another; the rotations must lead to the pose of `one`; on `two` the
    three axes are orthogonal.

    Args:
        motions: Pitch, yaw, roll, with axes as read.
        yaw_along: Which axis of the geometry yaw turns about.
        frames: Of the joint.
    """
    pitch, yaw, roll = motions
    inverse_pitch = transpose(_turn(pitch))
    # Yaw turns about where its axis is now, so it is undone before the pitch is.
    roll_axis = rotate(inverse_pitch, rotate(transpose(_turn(yaw)), roll.axis))
    read = pitch, yaw, roll
    carried = (
        pitch,
        replace(yaw, axis=rotate(inverse_pitch, yaw.axis)),
        replace(roll, axis=roll_axis),
    )
    if all(parallel(a.axis, b.axis) for a, b in zip(read, carried, strict=True)):
        return read, True
    for evidence in (_yaw_fits(yaw_along, frames), _pose_fits(frames), _orthogonal):
        fits = evidence(read), evidence(carried)
        if fits[0] != fits[1]:
            return (read if fits[0] else carried), True
    return read, False


Motions = tuple[MotionSnapshot, MotionSnapshot, MotionSnapshot]
Evidence = Callable[[Motions], bool]


def _yaw_fits(along: int, frames: JointFrames) -> Evidence:
    if along == CUSTOM or frames.two is None:
        return lambda motions: False
    axis = frames.two.axis(along)
    return lambda motions: parallel(motions[1].axis, axis)


def _pose_fits(frames: JointFrames) -> Evidence:
    if frames.one is None or frames.two is None:
        return lambda motions: False
    turned = multiply(frames.one.R, transpose(frames.two.R))
    return lambda motions: _same(turned, _product(motions))


def _orthogonal(motions: Motions) -> bool:
    pitch, yaw, roll = (motion.axis for motion in motions)
    return parallel(roll, cross(pitch, yaw))


def _product(motions: Motions) -> Matrix3:
    first, second, third = (_turn(motion) for motion in motions)
    return multiply(multiply(first, second), third)


def _turn(motion: MotionSnapshot) -> Matrix3:
    """The rotation by a motion's value about its axis."""
    return axis_rotation(motion.axis, motion.value)


def _same(A: Matrix3, B: Matrix3) -> bool:
    return all(
        abs(a - b) <= PARALLEL for r, s in zip(A, B, strict=True) for a, b in zip(r, s, strict=True)
    )
