"""Creation, recognition and deletion of construction points.

A parametric design accepts points at coordinates only while a base feature is edited. Since each
edit is slow, all points of a component are created in one edit. During the edit Fusion treats the
design as a direct design.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import adsk.core
import adsk.fusion

from ....fusion.units import CM
from ....muscles.attributes import GROUP, KeptPoint, without_tokens
from ....muscles.rows import PointRow
from ....robot.errors import InputError
from ....robot.model.pose import Vector3

BASE_FEATURE = "CARDSFlow points"
"""Name of the base feature with the points at coordinates."""


class ErrorContext:
    """Context manager that adds the name of an object to error messages."""

    def __init__(self, label: str, reason: str) -> None:
        self._label = label
        self._reason = reason

    def __enter__(self) -> None:
        pass

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if isinstance(error, Exception):
            reason = self._reason or str(error) or type(error).__name__
            raise InputError(f"{self._label} cannot be written: {reason}") from error


def set_attribute(owner: Any, name: str, text: str, label: str, reason: str = "") -> None:
    """Set an attribute if its text changes.

    Args:
        owner: The design, point or face.
        label: Name of the object for error messages.
        reason: Known reason why it cannot be written, or empty.
    """
    with ErrorContext(label, reason):
        attribute = owner.attributes.itemByName(GROUP, name)
        if attribute is None or without_tokens(attribute.value) != without_tokens(text):
            owner.attributes.add(GROUP, name, text)


def has_name(point: Any, name: str) -> bool:
    """Return whether a point has a name, possibly with the suffix of a duplicate name in Fusion.

    Names of via points are unique; a link may have several task points and markers.
    """
    if name.startswith("VP_"):
        return bool(point.name == name)
    return re.fullmatch(re.escape(name) + r"(?: ?\([0-9]+\))?", point.name) is not None


def added(points: Any, new: Any) -> Any:
    """Return the construction point that Fusion creates from an input."""
    point = points.add(new)
    if point is None:
        raise InputError("Fusion cannot create a construction point there")
    return native(point)


def native(entity: Any) -> Any:
    """Return the native entity of a proxy, which has the attributes and the name."""
    return None if entity is None else entity.nativeObject or entity


def make_points(
    design: Any, component: Any, occurrence: Any, positions: Sequence[Vector3]
) -> list[Any]:
    """Create construction points without names in a component."""
    places = [_in_component(position, occurrence) for position in positions]
    points = component.constructionPoints
    if design.designType == adsk.fusion.DesignTypes.DirectDesignType:
        return [added(points, _input(points, place)) for place in places]
    feature = _base_feature(component)
    before = feature.constructionPoints.count
    feature.startEdit()
    try:
        for place in places:
            new = _input(points, place)
            new.targetBaseOrFormFeature = feature
            added(points, new)
    finally:
        feature.finishEdit()
    # Objects that were created in the edit may be invalid after it. The caller checks positions.
    return [feature.constructionPoints.item(before + i) for i in range(len(places))]


def kept_point(row: PointRow, occurrence: Any, path: str) -> KeptPoint:
    """Return a point to store in the design, in the frame of an occurrence or of the root."""
    place = _in_component(row.position, occurrence)
    return KeptPoint(path, (place.x * CM, place.y * CM, place.z * CM), row.use)


def delete_points(points: Sequence[Any]) -> None:
    """Delete points that the add-in created, and base features without points."""
    features: list[tuple[Any, list[Any]]] = []
    for point in points:
        feature = point.baseFeature
        if not feature:
            point.deleteMe()
            continue
        in_feature = next((others for f, others in features if f == feature), None)
        if in_feature is None:
            features.append((feature, [point]))
        else:
            in_feature.append(point)
    for feature, those in features:
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
    """Return the base feature of a component for points; create it if it does not exist."""
    features = component.features.baseFeatures
    feature = features.itemByName(BASE_FEATURE)
    if feature is None:
        feature = features.add()
        feature.name = BASE_FEATURE
    return feature
