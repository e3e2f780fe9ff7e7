"""Construction points by coordinates, all of a component in one edit of a base feature.

A parametric design takes coordinates only while a base feature is edited; and every edit of one
takes Fusion a while. In the edit the design passes for a direct one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import adsk.core
import adsk.fusion

from ...fusion.units import CM
from ...muscles.attributes import KeptPoint
from ...robot.model.pose import Vector3
from .desired_points import DesiredPoint
from .edits import added

BASE_FEATURE = "CARDSFlow points"
"""Name of the base feature that holds points which no vertex, circle or sketch point holds."""


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


def kept_point(item: DesiredPoint, occurrence: Any, path: str) -> KeptPoint:
    """A point that is kept in the design, in the frame of an occurrence or of the root."""
    place = _in_component(item.row.position, occurrence)
    return KeptPoint(path, (place.x * CM, place.y * CM, place.z * CM), item.attribute)


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
    """The base feature of a component for such points; made if there is none."""
    features = component.features.baseFeatures
    feature = features.itemByName(BASE_FEATURE)
    if feature is None:
        feature = features.add()
        feature.name = BASE_FEATURE
    return feature
