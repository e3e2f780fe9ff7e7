"""Motions of joints and their limits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..base import Base, api, edited, new
from ..maths import vector
from ..state import world
from .data import Freedom, motion

RIGID, REVOLUTE, SLIDER, CYLINDRICAL, PIN_SLOT, PLANAR, BALL, INFERRED = range(8)


@api("adsk.fusion")
class JointLimits(Base):
    """Limits; values are 0 until they are enabled and set."""

    minimumValue = edited("limits.minimum", "float", "minimumValue")
    maximumValue = edited("limits.maximum", "float", "maximumValue")
    isMinimumValueEnabled = edited("limits.has_minimum", "bool", "isMinimumValueEnabled")
    isMaximumValueEnabled = edited("limits.has_maximum", "bool", "isMaximumValueEnabled")


@api("adsk.fusion")
class JointMotion(Base):
    """Motion of a joint, in the context of the joint."""

    def _is_gone(self) -> bool:
        return self._joint._is_gone()

    jointType = property(lambda self: self._joint._data.type)

    def _freedom(self, role: str) -> Freedom:
        return next(f for f in self._joint._data.freedoms if f.role == role)

    def _value(self, role: str) -> float:
        freedom = self._freedom(role)
        if self._joint._data.dragged and freedom.turns:
            return math.radians(round(math.degrees(freedom.value), 1))
        return freedom.value

    def _limits(self, role: str) -> Any:
        return new(JointLimits, limits=self._freedom(role).limits)

    def _vector(self, role: str) -> Any:
        """Return the direction in the root frame, fixed to `two` or moved (`ball_vectors`)."""
        freedoms = self._joint._data.freedoms
        freedom = self._freedom(role)
        R = self._joint._frame("two")[:3, :3]
        if world().options.ball_vectors == "carried" and self.jointType == BALL:
            R = R @ motion(freedoms[: freedoms.index(freedom)])[:3, :3]
        return vector(R @ np.asarray(freedom.axis, dtype=float))

    def _direction(self, role: str) -> int:
        """Return the value of JointDirections: x 0, y 1, z 2, custom 3."""
        axis = tuple(float(v) for v in self._freedom(role).axis)
        units = [tuple(row) for row in np.eye(3).tolist()]
        return units.index(axis) if axis in units else 3


def _of(method: Any) -> Any:
    """Return a function that creates a property from a method of `JointMotion` and a role."""

    def member(role: str) -> property:
        return property(lambda self: method(self, role))

    return member


_value, _limits = _of(JointMotion._value), _of(JointMotion._limits)
_axis, _direction = _of(JointMotion._vector), _of(JointMotion._direction)


@api("adsk.fusion")
class RigidJointMotion(JointMotion):
    pass


@api("adsk.fusion")
class RevoluteJointMotion(JointMotion):
    rotationAxis = _direction("rotation")
    rotationAxisVector = _axis("rotation")
    rotationLimits = _limits("rotation")
    rotationValue = _value("rotation")


@api("adsk.fusion")
class SliderJointMotion(JointMotion):
    slideDirection = _direction("slide")
    slideDirectionVector = _axis("slide")
    slideLimits = _limits("slide")
    slideValue = _value("slide")


@api("adsk.fusion")
class CylindricalJointMotion(JointMotion):
    """Cylindrical motion, which slides along its rotation axis and has no slide direction."""

    rotationAxis = _direction("rotation")
    rotationAxisVector = _axis("rotation")
    rotationLimits = _limits("rotation")
    rotationValue = _value("rotation")
    slideLimits = _limits("slide")
    slideValue = _value("slide")


@api("adsk.fusion")
class PinSlotJointMotion(JointMotion):
    rotationAxis = _direction("rotation")
    rotationAxisVector = _axis("rotation")
    rotationLimits = _limits("rotation")
    rotationValue = _value("rotation")
    slideDirection = _direction("slide")
    slideDirectionVector = _axis("slide")
    slideLimits = _limits("slide")
    slideValue = _value("slide")


@api("adsk.fusion")
class PlanarJointMotion(JointMotion):
    normalDirection = _direction("rotation")
    normalDirectionVector = _axis("rotation")
    rotationLimits = _limits("rotation")
    rotationValue = _value("rotation")
    primarySlideDirection = _direction("primarySlide")
    primarySlideDirectionVector = _axis("primarySlide")
    primarySlideLimits = _limits("primarySlide")
    primarySlideValue = _value("primarySlide")
    secondarySlideDirectionVector = _axis("secondarySlide")
    secondarySlideLimits = _limits("secondarySlide")
    secondarySlideValue = _value("secondarySlide")


@api("adsk.fusion")
class BallJointMotion(JointMotion):
    pitchDirection = _direction("pitch")
    pitchDirectionVector = _axis("pitch")
    pitchLimits = _limits("pitch")
    pitchValue = _value("pitch")
    yawDirection = _direction("yaw")
    yawDirectionVector = _axis("yaw")
    yawLimits = _limits("yaw")
    yawValue = _value("yaw")
    rollDirectionVector = _axis("roll")
    rollLimits = _limits("roll")
    rollValue = _value("roll")


MOTIONS = {
    RIGID: RigidJointMotion,
    REVOLUTE: RevoluteJointMotion,
    SLIDER: SliderJointMotion,
    CYLINDRICAL: CylindricalJointMotion,
    PIN_SLOT: PinSlotJointMotion,
    PLANAR: PlanarJointMotion,
    BALL: BallJointMotion,
}
