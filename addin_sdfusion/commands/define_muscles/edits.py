"""Single edits of the design, with errors that name their object."""

from __future__ import annotations

import re
from typing import Any

from ...robot.errors import InputError

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
    """Whether the point has that name, or the one that Fusion makes of a name that is taken.

    Via points have names of their own; a link may have several task points and markers.
    """
    if name.startswith("VP_"):
        return bool(point.name == name)
    return re.fullmatch(re.escape(name) + r"(?: ?\([0-9]+\))?", point.name) is not None


def added(points: Any, new: Any) -> Any:
    """The construction point that Fusion makes of an input."""
    made = points.add(new)
    if made is None:
        raise InputError("Fusion refuses to make a construction point there")
    return native(made)


def native(entity: Any) -> Any:
    """The entity itself, for a proxy: attributes and names belong to it."""
    return None if entity is None else entity.nativeObject or entity


def base_feature(component: Any) -> Any:
    """The base feature of a component that holds points by coordinates; made if there is none."""
    features = component.features.baseFeatures
    feature = features.itemByName(BASE_FEATURE)
    if feature is None:
        feature = features.add()
        feature.name = BASE_FEATURE
    return feature


def delete(point: Any) -> None:
    """Delete a point that the add-in made, and the base feature that holds nothing then."""
    feature = point.baseFeature
    if not feature:
        point.deleteMe()
        return
    feature.startEdit()
    try:
        point.deleteMe()
    finally:
        feature.finishEdit()
    if feature.name == BASE_FEATURE and feature.constructionPoints.count == 0:
        feature.deleteMe()
