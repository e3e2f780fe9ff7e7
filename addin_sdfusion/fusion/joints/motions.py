"""Degrees of freedom of a joint as reported by Fusion: axes, values, limits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import adsk.fusion

from ...robot.model.pose import Vector3
from ...snapshot import JointKind, MotionSnapshot
from ..units import CM, direction, finite

CUSTOM = 3
"""JointDirections of a custom axis; 0, 1 and 2 are the x, y and z axes of the joint."""


class Freedom(NamedTuple):
    """A motion and the index of its axis in the joint geometry.

    Attributes:
        motion: Motion with the axis reported by Fusion.
        along: 0, 1 or 2 for x, y or z of the geometry; CUSTOM if unknown.
    """

    motion: MotionSnapshot
    along: int


def joint_kinds() -> dict[int, JointKind]:
    """Return the joint kind of each joint type of Fusion."""
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
    """Return the degrees of freedom of a joint, ordered from `two` to `one`.

    Raises:
        ValueError: An axis or a number is missing.
    """
    return _READERS[kind](motion) if kind in _READERS else ()


def _rotation(motion: Any, role: str = "") -> Freedom:
    axis, value, limits = motion.rotationAxisVector, motion.rotationValue, motion.rotationLimits
    return _turn(axis, value, limits, role, motion.rotationAxis)


def _slide(motion: Any, role: str = "") -> Freedom:
    axis, value, limits = motion.slideDirectionVector, motion.slideValue, motion.slideLimits
    return _shift(axis, value, limits, role, motion.slideDirection)


def _cylindrical(motion: Any) -> tuple[Freedom, ...]:
    """Return the motions of a cylindrical joint, which slides along its rotation axis."""
    axis, value, limits = motion.rotationAxisVector, motion.slideValue, motion.slideLimits
    return _rotation(motion, "rotation"), _shift(axis, value, limits, "slide", motion.rotationAxis)


def _pin_slot(motion: Any) -> tuple[Freedom, ...]:
    """Return the motions of a pin that slides in the slot of `two` and rotates in it."""
    return _slide(motion, "slide"), _rotation(motion, "rotation")


def _planar(m: Any) -> tuple[Freedom, ...]:
    first = m.primarySlideDirectionVector, m.primarySlideValue, m.primarySlideLimits
    second = m.secondarySlideDirectionVector, m.secondarySlideValue, m.secondarySlideLimits
    turn = m.normalDirectionVector, m.rotationValue, m.rotationLimits
    return (
        _shift(*first, "primary_slide", m.primarySlideDirection),
        _shift(*second, "secondary_slide", CUSTOM),
        _turn(*turn, "rotation", m.normalDirection),
    )


def _ball(m: Any) -> tuple[Freedom, ...]:
    return (
        _turn(m.pitchDirectionVector, m.pitchValue, m.pitchLimits, "pitch", m.pitchDirection),
        _turn(m.yawDirectionVector, m.yawValue, m.yawLimits, "yaw", m.yawDirection),
        _turn(m.rollDirectionVector, m.rollValue, m.rollLimits, "roll", CUSTOM),
    )


_READERS: dict[JointKind, Callable[[Any], tuple[Freedom, ...]]] = {
    "revolute": lambda motion: (_rotation(motion),),
    "slider": lambda motion: (_slide(motion),),
    "cylindrical": _cylindrical,
    "pin_slot": _pin_slot,
    "planar": _planar,
    "ball": _ball,
}


def _turn(axis: Any, value: float, limits: Any, role: str, along: int) -> Freedom:
    span = _limits(limits, 1.0)
    return Freedom(MotionSnapshot("rotation", direction(axis), finite(value), *span, role), along)


def _shift(axis: Any, value: float, limits: Any, role: str, along: int) -> Freedom:
    span = _limits(limits, CM)
    motion = MotionSnapshot("translation", direction(axis), finite(value) * CM, *span, role)
    return Freedom(motion, along)


def _limits(limits: Any, unit: float) -> tuple[float | None, float | None]:
    """Return lower and upper limit; None for a limit that is not enabled."""
    if limits is None:
        return None, None
    lower = finite(limits.minimumValue) * unit if limits.isMinimumValueEnabled else None
    upper = finite(limits.maximumValue) * unit if limits.isMaximumValueEnabled else None
    return lower, upper


def reversed_axis(axis: Vector3) -> Vector3:
    """Return the opposite axis."""
    x, y, z = axis
    return -x, -y, -z
