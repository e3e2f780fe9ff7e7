"""The degrees of freedom of a joint as Fusion tells them: axes, values, limits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import adsk.fusion

from ...robot.model.pose import Vector3
from ...snapshot import JointKind, MotionSnapshot
from ..units import CM, direction, finite

CUSTOM = 3
"""JointDirections of an axis that is none of the joint's own; 0, 1 and 2 are x, y and z."""


class Freedom(NamedTuple):
    """A motion, and which axis of the joint's geometry it is along.

    Attributes:
        motion: Its axis is as Fusion tells it.
        along: 0, 1 or 2 for x, y or z of the geometry; CUSTOM where that is not told.
    """

    motion: MotionSnapshot
    along: int


def joint_kinds() -> dict[int, JointKind]:
    """What Fusion's types of joints are called here."""
    types = adsk.fusion.JointTypes
    return {
        types.RigidJointType: "rigid",
        types.RevoluteJointType: "revolute",
        types.SliderJointType: "slider",
        types.CylindricalJointType: "cylindrical",
        types.PinSlotJointType: "pin_slot",
        types.PlanarJointType: "planar",
        types.BallJointType: "ball",
        types.InferredJointType: "inferred",
    }


def read_freedoms(kind: JointKind, motion: Any) -> tuple[Freedom, ...]:
    """The degrees of freedom of a joint, in their order from `two` to `one`.

    Args:
        kind: The joint's type.
        motion: Its JointMotion.

    Raises:
        ValueError: An axis or a number is not told.
    """
    return _READERS[kind](motion) if kind in _READERS else ()


def _rotation(told: Any, role: str = "") -> Freedom:
    motion = _turn(told.rotationAxisVector, told.rotationValue, told.rotationLimits, role)
    return Freedom(motion, told.rotationAxis)


def _slide(told: Any, role: str = "") -> Freedom:
    motion = _shift(told.slideDirectionVector, told.slideValue, told.slideLimits, role)
    return Freedom(motion, told.slideDirection)


def _revolute(told: Any) -> tuple[Freedom, ...]:
    return (_rotation(told),)


def _slider(told: Any) -> tuple[Freedom, ...]:
    return (_slide(told),)


def _cylindrical(told: Any) -> tuple[Freedom, ...]:
    """It slides along the axis that it turns about: a direction of its own is not told."""
    slide = _shift(told.rotationAxisVector, told.slideValue, told.slideLimits, "slide")
    return _rotation(told, "rotation"), Freedom(slide, told.rotationAxis)


def _pin_slot(told: Any) -> tuple[Freedom, ...]:
    """The pin slides in the slot of `two`, and turns there."""
    return _slide(told, "slide"), _rotation(told, "rotation")


def _planar(told: Any) -> tuple[Freedom, ...]:
    first = _shift(
        told.primarySlideDirectionVector,
        told.primarySlideValue,
        told.primarySlideLimits,
        "primary_slide",
    )
    second = _shift(
        told.secondarySlideDirectionVector,
        told.secondarySlideValue,
        told.secondarySlideLimits,
        "secondary_slide",
    )
    turn = _turn(told.normalDirectionVector, told.rotationValue, told.rotationLimits, "rotation")
    return (
        Freedom(first, told.primarySlideDirection),
        Freedom(second, CUSTOM),
        Freedom(turn, told.normalDirection),
    )


def _ball(told: Any) -> tuple[Freedom, ...]:
    pitch = _turn(told.pitchDirectionVector, told.pitchValue, told.pitchLimits, "pitch")
    yaw = _turn(told.yawDirectionVector, told.yawValue, told.yawLimits, "yaw")
    roll = _turn(told.rollDirectionVector, told.rollValue, told.rollLimits, "roll")
    return (
        Freedom(pitch, told.pitchDirection),
        Freedom(yaw, told.yawDirection),
        Freedom(roll, CUSTOM),
    )


_READERS: dict[JointKind, Callable[[Any], tuple[Freedom, ...]]] = {
    "revolute": _revolute,
    "slider": _slider,
    "cylindrical": _cylindrical,
    "pin_slot": _pin_slot,
    "planar": _planar,
    "ball": _ball,
}


def _turn(axis: Any, value: float, limits: Any, role: str) -> MotionSnapshot:
    lower, upper = _limits(limits, 1.0)
    return MotionSnapshot("rotation", direction(axis), finite(value), lower, upper, role)


def _shift(axis: Any, value: float, limits: Any, role: str) -> MotionSnapshot:
    lower, upper = _limits(limits, CM)
    return MotionSnapshot("translation", direction(axis), finite(value) * CM, lower, upper, role)


def _limits(told: Any, unit: float) -> tuple[float | None, float | None]:
    """Lower and upper limit; a limit that is not enabled stands at 0 and means nothing."""
    if told is None:
        return None, None
    lower = finite(told.minimumValue) * unit if told.isMinimumValueEnabled else None
    upper = finite(told.maximumValue) * unit if told.isMaximumValueEnabled else None
    return lower, upper


def reversed_axis(axis: Vector3) -> Vector3:
    """The axis the other way round."""
    x, y, z = axis
    return -x, -y, -z
