"""Base features, which contain points at coordinates in parametric designs.

Importing this module adds members to Component, ConstructionPoint and ConstructionPoints. Objects
created through the API belong to the add-in, so only the full fingerprint includes them.

A construction point of a base feature can be created and deleted only while the feature is edited
[reference: ConstructionPointInput.targetBaseOrFormFeature]. Its Point3D is in the frame of the
component [inferred]. All objects of its points become invalid when an edit ends [inferred].
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..base import Base, _guarded, api, new
from ..collections_ import Items, named
from ..state import world
from .captures import revert
from .component import Component
from .data import Named, PointData
from .entity import Deletable, Seen, WithName, reject_reference, unique, wrap, wraps
from .points import ConstructionPoint, ConstructionPointInput, ConstructionPoints, _place
from .timeline import WithTimeline


@dataclass(eq=False)
class BaseFeatureData(Named):
    """A base feature."""

    component: Any = None
    points: list[PointData] = field(default_factory=list)
    edited: int = 0
    is_edited: bool = False


@api("adsk.fusion")
@wraps(BaseFeatureData)
class BaseFeature(WithName, WithTimeline, Deletable):
    def _shelf(self) -> list[Any]:
        return self._data.component.base_features

    def _siblings(self) -> list[Any]:
        return self._shelf()

    parentComponent = property(lambda self: wrap(self._data.component))
    constructionPoints = property(lambda self: new(_PointsOfFeature, feature=self._data))

    def startEdit(self) -> bool:
        reject_reference(self._data.component, "BaseFeature.startEdit")
        if any(f.is_edited for f in self._shelf()):
            raise RuntimeError("3 : a base feature is being edited already")
        self._data.is_edited = True
        world().edit_scopes += 1
        return True

    def finishEdit(self) -> bool:
        world().require_edit("BaseFeature.finishEdit")
        if not self._data.is_edited:
            raise RuntimeError("3 : the base feature is not being edited")
        self._data.is_edited = False
        world().recomputes += 1
        self._data.edited = world().recomputes
        return True

    def deleteMe(self) -> bool:
        if self._data.points:
            raise RuntimeError("3 : the base feature still holds points")
        return super().deleteMe()


class _PointsOfFeature(ConstructionPoints):
    """The points of a base feature."""

    def _all(self) -> list[Any]:
        return [wrap(p) for p in self._feature.points]


@api("adsk.fusion")
@named
class BaseFeatures(Items):
    """Base features of a component."""

    def _all(self) -> list[Any]:
        return [wrap(f) for f in self._component.base_features]

    def add(self) -> Any:
        component = self._component
        reject_reference(component, "BaseFeatures.add")
        if component.design.kind == 0:
            raise RuntimeError("3 : direct designs have no base features")
        if component.design.intent == 1 and component is component.design.root:
            raise RuntimeError("3 : an assembly design takes no features")
        shelf = component.base_features
        data = BaseFeatureData(unique("BaseFeature1", shelf), component=component)
        world().append(shelf, data, "BaseFeatures.add")
        return wrap(data)


@api("adsk.fusion")
class Features(Base):
    """Features of a component; the fake has only base features."""

    baseFeatures = property(lambda self: new(BaseFeatures, component=self._component))


def _component_features(self: Any) -> Any:
    return new(Features, component=self._data)


def _target(self: Any) -> Any:
    return self.__dict__.get("_feature")


def _set_target(self: Any, value: BaseFeature | None) -> None:
    self._feature = value


def _base_feature(self: Any) -> Any:
    return wrap(self._data.__dict__.get("base_feature"))


_add, _delete = ConstructionPoints.add, ConstructionPoint.deleteMe


def _set_name(self: Any, value: str) -> None:
    """Set the name of a point, which is allowed after the edit of its base feature [reference]."""
    feature = self._data.__dict__.get("base_feature")
    if feature is not None and feature.is_edited:
        raise RuntimeError("3 : the point cannot be named while its base feature is edited")
    WithName.name.fset(self, value)


def _add_to_feature(self: Any, made: ConstructionPointInput) -> Any:
    feature = made.targetBaseOrFormFeature
    if feature is None:
        return _add(self, made)
    component = self._component
    reject_reference(component, "ConstructionPoints.add")
    if feature._data.component is not component or not feature._data.is_edited:
        raise RuntimeError("3 : the base feature is of another component, or not being edited")
    if made._how is None:
        raise RuntimeError("3 : the input of the construction point is not set")
    position = _place(component, made._how[1], made._occurrence)
    name = unique(f"Point{len(component.points) + 1}", component.points)
    data = PointData(name, component=component, position=position, by_user=False)
    data.base_feature = feature._data
    world().append(component.points, data, "ConstructionPoints.add")
    world().append(feature._data.points, data, "ConstructionPoints.add")
    revert(component.design)
    return wrap(data)


def _is_gone(self: Any) -> bool:
    """Return whether the point was deleted, or an edit of its base feature has ended since."""
    feature = self._data.__dict__.get("base_feature")
    return (feature is not None and self._is_before(feature.edited)) or Seen._is_gone(self)


def _delete_from_feature(self: Any) -> bool:
    feature = self._data.__dict__.get("base_feature")
    if feature is not None:
        if not feature.is_edited:
            raise RuntimeError("3 : the point's base feature is not being edited")
        world().remove(feature.points, self._data)
    return _delete(self)


ConstructionPoint._is_gone = _is_gone  # type: ignore[method-assign]

for _class, _name, _member in (
    (Component, "features", property(_component_features)),
    (ConstructionPoint, "baseFeature", property(_base_feature)),
    (ConstructionPoint, "deleteMe", _delete_from_feature),
    (ConstructionPoint, "name", property(WithName.name.fget, _set_name)),
    (ConstructionPoints, "add", _add_to_feature),
    (ConstructionPointInput, "targetBaseOrFormFeature", property(_target, _set_target)),
):
    setattr(_class, _name, _guarded(_class, _name, _member))
