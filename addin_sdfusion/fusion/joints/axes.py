"""Axes of joints in the root frame, with signs such that a value moves `one` relative to `two`.

An axis is fixed to `two`: it is the direction in the root frame at the pose of `two` if the
preceding motions of the joint are zero. Fusion reports axes in the root frame. A positive slide
moves `one` along the axis.
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
from ..units import PARALLEL, chord, parallel
from .frames import JointFrames
from .motions import CUSTOM, reversed_axis


def correct_signs(
    motions: Sequence[MotionSnapshot], frames: JointFrames
) -> tuple[MotionSnapshot, ...]:
    """Return the motions of a joint without offsets, with corrected signs of rotation axes.

    The rotation of `one` relative to `two` follows from the frames of the joint. If it equals the
    rotation by the negative value, the axis is reversed.
    """
    if frames.one is None or frames.two is None:
        return tuple(motions)
    turned = multiply(frames.one.R, transpose(frames.two.R))
    return tuple(_correct_sign(motion, turned) for motion in motions)


def _correct_sign(motion: MotionSnapshot, turned: Matrix3) -> MotionSnapshot:
    if motion.kind == "translation":
        return motion
    back = replace(motion, axis=reversed_axis(motion.axis))
    wrong = _same(turned, _turn(back)) and not _same(turned, _turn(motion))
    return back if wrong else motion


def ball_axes(
    motions: Sequence[MotionSnapshot], yaw_along: int, frames: JointFrames
) -> tuple[tuple[MotionSnapshot, ...], bool]:
    """Return pitch, yaw and roll with axes fixed to `two`, and whether the axes are certain.

    It is not documented whether Fusion reports the axes of a ball joint fixed to `two`, or rotated
    by the preceding rotations. Three criteria select one:

    * The yaw axis is an axis of the geometry unless the user chose another one.
    * The rotations must result in the pose of `one`.
    * On `two`, the roll axis is perpendicular to the other axes.

    Fusion rounds values to 0.1 degrees. An axis that is rotated back by them has the same
    resolution, but an axis of the geometry is exact.

    Args:
        motions: Pitch, yaw, roll, with axes as read.
        yaw_along: Index of the geometry axis of yaw.
    """
    pitch, yaw, roll = motions
    inverse_pitch = transpose(_turn(pitch))
    # Yaw rotates about the current axis, so it is undone before pitch.
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
        nearest = min((read, carried), key=lambda m: chord(m[1].axis, axis) + _roll_error(m))
        if chord(nearest[1].axis, axis) <= _MAX_ROUNDING:
            return _on_geometry(nearest, axis), True
    for misses in (_pose_error(frames), _roll_error):
        first, second = misses(read), misses(carried)
        if min(first, second) <= _MAX_ROUNDING and max(first, second) > _MIN_RATIO * min(
            first, second
        ):
            return (read if first < second else carried), True
    return read, False


Motions = tuple[MotionSnapshot, MotionSnapshot, MotionSnapshot]
_MAX_ROUNDING = 4e-3  # error of the axes because values are rounded to 0.1 degrees, in [rad]
_MIN_RATIO = 5.0  # of the errors of two readings, to prefer the smaller one


def _on_geometry(motions: Motions, axis: Vector3) -> Motions:
    """Return the motions with a given yaw axis, and roll made perpendicular if it nearly is."""
    pitch, yaw, roll = motions
    yaw = replace(yaw, axis=_along(axis, yaw.axis))
    square = normalized(cross(pitch.axis, yaw.axis))
    if chord(square, roll.axis) <= _MAX_ROUNDING:
        roll = replace(roll, axis=_along(square, roll.axis))
    return pitch, yaw, roll


def _along(axis: Vector3, other: Vector3) -> Vector3:
    """Return the axis or its negative, whichever is closer to the other."""
    return axis if dot(axis, other) >= 0.0 else reversed_axis(axis)


def _pose_error(frames: JointFrames) -> Callable[[Motions], float]:
    if frames.one is None or frames.two is None:
        return lambda motions: 1.0
    turned = multiply(frames.one.R, transpose(frames.two.R))
    return lambda motions: _difference(turned, _product(motions))


def _roll_error(motions: Motions) -> float:
    pitch, yaw, roll = (motion.axis for motion in motions)
    return chord(roll, cross(pitch, yaw))


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
