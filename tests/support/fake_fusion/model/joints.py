"""Joints, as-built joints, joint origins, rigid groups and assembly constraints."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import Base, api, edited, new
from ..collections_ import Items, named
from ..maths import matrix, point, vector
from ..state import world
from .data import (
    JointData,
    JointOriginData,
    Path,
    first_instance,
    relative_pose,
    transform,
)
from .entity import Deletable, Placed, WithName, WithVisibility, occurrence, wrap, wraps
from .joint_motions import INFERRED, MOTIONS, RIGID
from .timeline import WithTimeline


@api("adsk.fusion")
class JointGeometry(Base):
    """Transient geometry: origin in the root frame, axes in the component frame [live]."""

    origin = property(lambda self: point((self._T_root @ self._T)[:3, 3]))
    primaryAxisVector = property(lambda self: vector(self._T[:3, 2]))
    secondaryAxisVector = property(lambda self: vector(self._T[:3, 0]))
    thirdAxisVector = property(lambda self: vector(self._T[:3, 1]))


def _geometry(T: np.ndarray, T_root: np.ndarray) -> Any:
    """Return a JointGeometry.

    Args:
        T: Frame of the joint in the component of the geometry.
        T_root: Pose of that component in the root frame.
    """
    return new(JointGeometry, T=T, T_root=T_root)


class Sibling(Placed, WithName, WithTimeline, Deletable):
    parentComponent = property(lambda self: wrap(self._data.component))

    def _siblings(self) -> list[Any]:
        return self._shelf()


@api("adsk.fusion")
@wraps(JointOriginData)
class JointOrigin(Sibling):
    """Joint origin; it has no attribute `origin`, only its geometry has one."""

    def _shelf(self) -> list[Any]:
        return self._data.component.joint_origins

    @property
    def _T_root(self) -> np.ndarray:
        """Pose of the component; without a context, of its first occurrence [live]."""
        return transform(self._path or first_instance(self._data.component))

    transform = property(lambda self: matrix(_told(self._T, self._data.T)))
    geometry = property(lambda self: _geometry(self._data.T, self._T_root))
    primaryAxisVector = property(lambda self: vector(self._data.T[:3, 2]))
    secondaryAxisVector = property(lambda self: vector(self._data.T[:3, 0]))
    thirdAxisVector = property(lambda self: vector(self._data.T[:3, 1]))


def relative(context: Path, path: Path) -> np.ndarray:
    """Return the pose of an occurrence in the component at the end of a context."""
    T = np.eye(4)
    for k in range(len(path)):
        T = T @ relative_pose((*context, *path[: k + 1]))
    return T


def _told(T_context: np.ndarray, T: np.ndarray) -> np.ndarray:
    """Return the transform that a proxy reports for a transform in the component frame."""
    lifted = world().options.joint_transforms == "context"
    return T_context @ T if lifted else T


class _AnyJoint(Sibling, WithVisibility):
    @property
    def _nested_native(self) -> bool:
        return not self._path and self._data.component is not self._data.component.design.root

    def createForAssemblyContext(self, occurrence: Occurrence) -> Any:  # noqa: F821
        if self._path:
            return None
        if occurrence._data.component is not self._component:
            raise RuntimeError("3 : invalid argument occurrence: it is of another component")
        return wrap(self._data, occurrence._path)

    def _own_frame(self, side: str) -> np.ndarray:
        """Return the joint frame on `one` or `two` in the component that contains the joint."""
        T = relative(self._path, getattr(self._data, side))
        return T @ getattr(self._data, f"T_{side}")

    def _frame(self, side: str) -> np.ndarray:
        """Return this frame in the root frame; without a context, of the first occurrence."""
        return transform(self._path or self._first) @ self._own_frame(side)

    @property
    def _first(self) -> Path:
        return first_instance(self._data.component)

    def _side_geometry(self, side: str) -> Any:
        """Return the geometry of a side, which refers to the first occurrence [live]."""
        path = (*self._first, *getattr(self._data, side))
        return _geometry(getattr(self._data, f"T_{side}"), transform(path))

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
        origin = getattr(data, f"origin_{side}")
        return self._side_geometry(side) if origin is None else wrap(origin)

    geometryOrOriginOne = property(lambda self: self._geometry_or_origin("one"))
    geometryOrOriginTwo = property(lambda self: self._geometry_or_origin("two"))

    @property
    def geometryOneTransform(self) -> Any:
        if self._data.type == INFERRED:
            return None
        return matrix(_told(transform(self._path), self._own_frame("one")))

    @property
    def geometryTwoTransform(self) -> Any:
        if self._data.type == INFERRED:
            return None
        return matrix(_told(transform(self._path), self._own_frame("two")))

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
    """As-built joint, without health state, lock and second geometry."""

    def _shelf(self) -> list[Any]:
        return self._data.component.as_built

    @property
    def geometry(self) -> Any:
        if self._data.type == RIGID or self._data.broken_geometry:
            return None
        if self._nested_native and world().options.nested_native_geometry == "null":
            return None
        return self._side_geometry("two")

    @property
    def transform(self) -> Any:
        """Transform in the frame of the component of the joint, for any proxy [live]."""
        return None if self._data.type == RIGID else matrix(self._own_frame("two"))


def _parameter(joint: JointData, value: float) -> Any:
    return None if joint.type == INFERRED else new(ModelParameter, value=value)


@api("adsk.fusion")
class Parameter(Base):
    value = property(lambda self: self._value)


@api("adsk.fusion")
class ModelParameter(Parameter):
    pass


class _Shelf(Items):
    """Collection of a component; `_component` is ComponentData."""

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
class AssemblyConstraint(Base):
    """Assembly constraint, only a name in the fake."""

    name = property(lambda self: self._name)


@api("adsk.fusion")
@named
class AssemblyConstraints(Items):
    def _all(self) -> list[Any]:
        return [new(AssemblyConstraint, name=n) for n in self._component.constraints]
