"""Axes of joints in the root frame, signed so that a value moves `one` relative to `two`.

An axis is that on `two`: the direction that it has in the root frame at the pose of `two`, when the
motions before it in the joint are at zero. Fusion gives it in the root frame, and `one` of a slide
moves along it.
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
    normalized,
    rotate,
    transpose,
)
from ...snapshot import MotionSnapshot
from ..units import PARALLEL, distance, parallel
from .frames import JointFrames
from .motions import CUSTOM, reversed_axis


def signed(motions: Sequence[MotionSnapshot], frames: JointFrames) -> tuple[MotionSnapshot, ...]:
    """Return the motions of a joint without offsets, a rotation reversed where its value says so.

    How `one` is turned on `two` is known from the joint's frames. If it is exactly how the value
    would turn it the other way round, the axis is reversed.
    """
    if frames.one is None or frames.two is None:
        return tuple(motions)
    turned = multiply(frames.one.R, transpose(frames.two.R))
    return tuple(_signed(motion, turned) for motion in motions)


def _signed(motion: MotionSnapshot, turned: Matrix3) -> MotionSnapshot:
    if motion.kind == "translation":
        return motion
    back = replace(motion, axis=reversed_axis(motion.axis))
    wrong = _same(turned, _turn(back)) and not _same(turned, _turn(motion))
    return back if wrong else motion


def ball_axes(
    motions: Sequence[MotionSnapshot], yaw_along: int, frames: JointFrames
) -> tuple[tuple[MotionSnapshot, ...], bool]:
    """Pitch, yaw and roll with axes as on `two`, and whether it is certain that they are.

    It is not documented whether Fusion gives the axes of a ball joint as they are on `two`, or each
    as the rotations before it have carried it. Three things decide: the yaw axis is the geometry's
    unless the user chose another; the rotations must lead to the pose of `one`; on `two` the roll
    axis is square to the others. Values come on a grid of 0.1 degrees, so that what is carried
    back by them is as coarse; an axis of the geometry is not.

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
    if yaw_along != CUSTOM and frames.two is not None:
        axis = frames.two.axis(yaw_along)
        nearest = min((read, carried), key=lambda m: _angle(m[1].axis, axis) + _roll_misses(m))
        if _angle(nearest[1].axis, axis) <= _GRID:
            return _on_geometry(nearest, axis), True
    for misses in (_pose_misses(frames), _roll_misses):
        first, second = misses(read), misses(carried)
        if min(first, second) <= _GRID and max(first, second) > _CLEARER * min(first, second):
            return (read if first < second else carried), True
    return read, False


Motions = tuple[MotionSnapshot, MotionSnapshot, MotionSnapshot]
_GRID = 4e-3  # what values on a grid of 0.1 degrees make uncertain at most, in [rad]
_CLEARER = 5.0


def _on_geometry(motions: Motions, axis: Vector3) -> Motions:
    """The motions with that yaw axis, and roll square to pitch and yaw where it nearly is."""
    pitch, yaw, roll = motions
    yaw = replace(yaw, axis=_along(axis, yaw.axis))
    square = normalized(cross(pitch.axis, yaw.axis))
    if _angle(square, roll.axis) <= _GRID:
        roll = replace(roll, axis=_along(square, roll.axis))
    return pitch, yaw, roll


def _along(axis: Vector3, other: Vector3) -> Vector3:
    """Return the axis, pointing the way of the other."""
    return axis if dot(axis, other) >= 0.0 else reversed_axis(axis)


def _angle(a: Vector3, b: Vector3) -> float:
    """By how much two axes differ, whichever way they point, as a chord."""
    return min(distance(a, b), distance(a, reversed_axis(b)))


def _pose_misses(frames: JointFrames) -> Callable[[Motions], float]:
    if frames.one is None or frames.two is None:
        return lambda motions: 1.0
    turned = multiply(frames.one.R, transpose(frames.two.R))
    return lambda motions: _difference(turned, _product(motions))


def _roll_misses(motions: Motions) -> float:
    pitch, yaw, roll = (motion.axis for motion in motions)
    return _angle(roll, cross(pitch, yaw))


def _product(motions: Motions) -> Matrix3:
    first, second, third = (_turn(motion) for motion in motions)
    return multiply(multiply(first, second), third)


def _turn(motion: MotionSnapshot) -> Matrix3:
    """Return the rotation by a motion's value about its axis."""
    return axis_rotation(motion.axis, motion.value)


def _same(A: Matrix3, B: Matrix3) -> bool:
    return _difference(A, B) <= PARALLEL


def _difference(A: Matrix3, B: Matrix3) -> float:
    pairs = zip(A, B, strict=True)
    return max(abs(a - b) for r, s in pairs for a, b in zip(r, s, strict=True))
