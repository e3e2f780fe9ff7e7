"""Joints, as-built joints, joint origins, rigid groups and assembly constraints."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import Base, api, edited, new
from ..collections_ import Items, named
from ..maths import inverse, matrix, point, vector
from ..state import world
from .data import JointData, JointOriginData, transform
from .entity import Deletable, Placed, WithBulb, WithName, WithVisibility, occurrence, wrap, wraps
from .joint_motions import INFERRED, MOTIONS, RIGID


@api("adsk.fusion")
class JointGeometry(Base):
    """Transient: a frame, as far as the joint's context knows."""

    origin = property(lambda self: point(self._T[:3, 3]))
    primaryAxisVector = property(lambda self: vector(self._T[:3, 2]))
    secondaryAxisVector = property(lambda self: vector(self._T[:3, 0]))
    thirdAxisVector = property(lambda self: vector(self._T[:3, 1]))


def _geometry(T_context: np.ndarray, T_component: np.ndarray) -> Any:
    """A JointGeometry whose component is at T_component in the context.

    Args:
        T_context: The frame in the context.
        T_component: Pose of the occurrence that the geometry belongs to, in the context.
    """
    if world().options.geometry_origin == "component":
        return new(JointGeometry, T=inverse(T_component) @ T_context)
    return new(JointGeometry, T=T_context)


class Sibling(Placed, WithName, Deletable):
    parentComponent = property(lambda self: wrap(self._data.component))

    def _siblings(self) -> list[Any]:
        return self._shelf()


@api("adsk.fusion")
@wraps(JointOriginData)
class JointOrigin(Sibling, WithBulb):
    """Has no origin of its own: that is its geometry's."""

    def _shelf(self) -> list[Any]:
        return self._data.component.joint_origins

    transform = property(lambda self: matrix(self._T @ self._data.T))
    geometry = property(lambda self: _geometry(self._T @ self._data.T, self._T))
    primaryAxisVector = property(lambda self: vector((self._T @ self._data.T)[:3, 2]))
    secondaryAxisVector = property(lambda self: vector((self._T @ self._data.T)[:3, 0]))
    thirdAxisVector = property(lambda self: vector((self._T @ self._data.T)[:3, 1]))


class _AnyJoint(Sibling, WithBulb, WithVisibility):
    @property
    def _nested_native(self) -> bool:
        return not self._path and self._data.component is not self._data.component.design.root

    def createForAssemblyContext(self, occurrence: Occurrence) -> Any:  # noqa: F821
        if self._path:
            return None
        if occurrence._data.component is not self._component:
            raise RuntimeError("3 : invalid argument occurrence: it is of another component")
        return wrap(self._data, occurrence._path)

    def _frame(self, side: str) -> np.ndarray:
        """The joint's frame on `one` or `two` in the context."""
        T = self._T @ transform(getattr(self._data, side))
        return T @ getattr(self._data, f"T_{side}")

    @property
    def occurrenceOne(self) -> Any:
        return occurrence((*self._path, *self._data.one)) if self._data.one else None

    @property
    def occurrenceTwo(self) -> Any:
        return occurrence((*self._path, *self._data.two)) if self._data.two else None

    isSuppressed = edited("data.suppressed", "bool", "isSuppressed")

    @property
    def jointMotion(self) -> Any:
        cls = MOTIONS.get(self._data.type)
        return None if cls is None else new(cls, joint=self)


@api("adsk.fusion")
@wraps((JointData, "joint"))
class Joint(_AnyJoint):
    def _shelf(self) -> list[Any]:
        return self._data.component.joints

    def _geometry_or_origin(self, side: str) -> Any:
        data = self._data
        if data.type == INFERRED or data.broken_geometry:
            return None
        if self._nested_native and world().options.nested_native_geometry == "null":
            return None
        path = (*self._path, *getattr(data, side))
        origin = getattr(data, f"origin_{side}")
        if origin is not None:
            return wrap(origin, path)
        return _geometry(self._frame(side), transform(path))

    geometryOrOriginOne = property(lambda self: self._geometry_or_origin("one"))
    geometryOrOriginTwo = property(lambda self: self._geometry_or_origin("two"))

    @property
    def geometryOneTransform(self) -> Any:
        return None if self._data.type == INFERRED else matrix(self._frame("one"))

    @property
    def geometryTwoTransform(self) -> Any:
        return None if self._data.type == INFERRED else matrix(self._frame("two"))

    isLocked = edited("data.locked", "bool", "isLocked")

    isFlipped = property(lambda self: self._data.flipped)
    healthState = property(lambda self: 3 if self._data.suppressed else self._data.health)
    errorOrWarningMessage = property(lambda self: self._data.problem)
    angle = property(lambda self: _parameter(self._data, self._data.angle))
    offset = property(lambda self: _parameter(self._data, self._data.offsets[2]))
    offsetX = property(lambda self: _parameter(self._data, self._data.offsets[0]))
    offsetY = property(lambda self: _parameter(self._data, self._data.offsets[1]))


@api("adsk.fusion")
@wraps((JointData, "as-built"))
class AsBuiltJoint(_AnyJoint):
    """Has neither health, nor lock, nor a second geometry."""

    def _shelf(self) -> list[Any]:
        return self._data.component.as_built

    @property
    def geometry(self) -> Any:
        if self._data.type == RIGID or self._data.broken_geometry:
            return None
        if self._nested_native and world().options.nested_native_geometry == "null":
            return None
        return _geometry(self._frame("two"), transform((*self._path, *self._data.two)))

    @property
    def transform(self) -> Any:
        return None if self._data.type == RIGID else matrix(self._frame("two"))


def _parameter(joint: JointData, value: float) -> Any:
    return None if joint.type == INFERRED else new(ModelParameter, value=value)


@api("adsk.fusion")
class Parameter(Base):
    value = property(lambda self: self._value)


@api("adsk.fusion")
class ModelParameter(Parameter):
    pass


class _Shelf(Items):
    """`_component` is ComponentData."""

    _name = ""

    def _all(self) -> list[Any]:
        return [wrap(item) for item in getattr(self._component, self._name)]


@api("adsk.fusion")
@named
class Joints(_Shelf):
    _name = "joints"


@api("adsk.fusion")
@named
class AsBuiltJoints(_Shelf):
    _name = "as_built"


@api("adsk.fusion")
@named
class JointOrigins(_Shelf):
    _name = "joint_origins"


@api("adsk.fusion")
@named
class RigidGroups(_Shelf):
    _name = "groups"


@api("adsk.fusion")
@named
class JointList(Items):
    pass


@api("adsk.fusion")
@named
class AsBuiltJointList(Items):
    pass


@api("adsk.fusion")
@named
class RigidGroupList(Items):
    pass


@api("adsk.fusion")
class AssemblyConstraint(Base):
    """Here a name only."""

    name = property(lambda self: self._name)


@api("adsk.fusion")
@named
class AssemblyConstraints(Items):
    def _all(self) -> list[Any]:
        return [new(AssemblyConstraint, name=n) for n in self._component.constraints]
