"""Construction points of the design: made, recognised and deleted.

Those at coordinates are made all of a component in one edit of a base feature: a parametric design
takes coordinates only while a base feature is edited; and every edit of one takes Fusion a while.
In the edit the design passes for a direct one.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import adsk.core
import adsk.fusion

from ...fusion.units import CM
from ...muscles.attributes import KeptPoint
from ...muscles.table import PointRow
from ...robot.errors import InputError
from ...robot.model.pose import Vector3

BASE_FEATURE = "CARDSFlow points"
"""Name of the base feature that holds points which no vertex, circle or sketch point holds."""


class About:
    """What fails within names the object that it failed for."""

    def __init__(self, what: str, why: str) -> None:
        self._what = what
        self._why = why

    def __enter__(self) -> None:
        pass

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if isinstance(error, Exception):
            why = self._why or str(error) or type(error).__name__
            raise InputError(f"{self._what} cannot be written: {why}") from error


def is_called(point: Any, name: str) -> bool:
    """Return whether the point has that name, or the one that Fusion makes of a name that is taken.

    Via points have separate names; a link may have several task points and markers.
    """
    if name.startswith("VP_"):
        return bool(point.name == name)
    return re.fullmatch(re.escape(name) + r"(?: ?\([0-9]+\))?", point.name) is not None


def added(points: Any, new: Any) -> Any:
    """Return the construction point that Fusion makes of an input."""
    made = points.add(new)
    if made is None:
        raise InputError("Fusion cannot create a construction point there")
    return native(made)


def native(entity: Any) -> Any:
    """Return the entity itself, for a proxy: attributes and names belong to it."""
    return None if entity is None else entity.nativeObject or entity


def make_points(
    design: Any, component: Any, occurrence: Any, positions: Sequence[Vector3]
) -> list[Any]:
    """Construction points of a component, not named yet.

    Args:
        design: The design.
        component: Takes the points.
        occurrence: Where the component is; None for the root.
        positions: In the root frame, in [m].
    """
    places = [_in_component(position, occurrence) for position in positions]
    points = component.constructionPoints
    if design.designType == adsk.fusion.DesignTypes.DirectDesignType:
        return [added(points, _input(points, place)) for place in places]
    feature = _base_feature(component)
    feature.startEdit()
    try:
        made = []
        for place in places:
            new = _input(points, place)
            new.targetBaseOrFormFeature = feature
            made.append(added(points, new))
    finally:
        feature.finishEdit()
    return made


def kept_point(row: PointRow, occurrence: Any, path: str) -> KeptPoint:
    """Return a point that is kept in the design, in the frame of an occurrence or of the root."""
    place = _in_component(row.position, occurrence)
    return KeptPoint(path, (place.x * CM, place.y * CM, place.z * CM), row.use)


def delete_points(points: Sequence[Any]) -> None:
    """Delete points that the add-in made, and base features that hold nothing then."""
    held: list[tuple[Any, list[Any]]] = []
    for point in points:
        feature = point.baseFeature
        if not feature:
            point.deleteMe()
            continue
        known = next((others for f, others in held if f == feature), None)
        if known is None:
            held.append((feature, [point]))
        else:
            known.append(point)
    for feature, those in held:
        feature.startEdit()
        try:
            for point in those:
                point.deleteMe()
        finally:
            feature.finishEdit()
        if feature.name == BASE_FEATURE and feature.constructionPoints.count == 0:
            feature.deleteMe()


def _input(points: Any, place: Any) -> Any:
    new = points.createInput()
    new.setByPoint(place)
    return new


def _in_component(position: Vector3, occurrence: Any) -> Any:
    place = adsk.core.Point3D.create(*(v / CM for v in position))
    if occurrence:
        to_component = occurrence.transform2.copy()
        to_component.invert()
        place.transformBy(to_component)
    return place


def _base_feature(component: Any) -> Any:
    """Return the base feature of a component for such points; create it if it does not exist."""
    features = component.features.baseFeatures
    feature = features.itemByName(BASE_FEATURE)
    if feature is None:
        feature = features.add()
        feature.name = BASE_FEATURE
    return feature
