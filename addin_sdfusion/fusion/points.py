"""Construction points of the add-in, identified by name or attributes, in every occurrence."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import Any, TypeVar

import adsk.fusion

from ..muscles.attributes import GROUP, POINT, partial_use
from ..muscles.point_names import is_point_name
from ..muscles.stored import stored_point
from ..robot.finding import Subject
from ..robot.model.pose import Vector3
from ..snapshot import HIDDEN_KEY, PointSnapshot, PointUse, SurfaceUse
from .health import problem_of
from .names import Keys
from .notes import Notes, optional
from .occurrences import Occurrence, component_id, each_in, subject_in
from .places import HIDDEN, Places, copied
from .units import position

Use = TypeVar("Use", PointUse, SurfaceUse)


def read_points(
    occurrence: Occurrence, keys: Keys, places: Places, notes: Notes
) -> Iterator[PointSnapshot]:
    """Yield the points in an occurrence."""
    component = occurrence.component
    points = []
    for native, name, proxy in each_in(
        occurrence, lambda: component.constructionPoints, notes, "point"
    ):
        subject = subject_in(occurrence, "point", name)
        attributes = notes.attempt(subject, "attributes", own_attributes, native)
        if not attributes and not is_point_name(name):
            continue
        problem = notes.attempt(subject, "state", problem_of, native, subject, notes)
        read = notes.attempt(subject, "position", _positions, occurrence, native, proxy)
        if read is not None:
            use, lost = _use(attributes or {}, name, occurrence, places, notes)
            points.append((name, read, use, problem or "", lost))
    count: dict[str, int] = {}
    # Sorted by position in the component, which is the same in every occurrence.
    points.sort(key=lambda point: (point[0], point[1][0]))
    for name, (_, in_root), use, problem, lost in points:
        number = count[name] = count.get(name, -1) + 1
        key = keys.key(occurrence, name, number)
        yield PointSnapshot(name, occurrence.path, in_root, key, use, problem, lost)


def _use(
    attributes: dict[str, str], name: str, occurrence: Occurrence, places: Places, notes: Notes
) -> tuple[PointUse | None, str]:
    """Return the stored use of a point, and the reason if its occurrence is unknown."""
    use = stored_point(attributes, name, notes.findings)
    if use is None:
        bad = partial_use(_plain(attributes.get(POINT, "")))
        return bad, "its record cannot be read" if bad else ""
    return with_occurrence(use, Subject("point", name), occurrence.path, places, notes)


def _plain(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None


def hidden_points(design: Any, visible: Collection[str]) -> Iterator[tuple[str, Any, str]]:
    """Yield key, point and record of points whose component has no occurrence.

    Args:
        visible: Persistent ids of all components with an occurrence.
    """
    for attribute in optional(lambda: list(design.findAttributes(GROUP, POINT))) or ():
        parent = optional(lambda: attribute.parent)  # noqa: B023 -- called at once
        point = adsk.fusion.ConstructionPoint.cast(parent)
        read = optional(lambda: _hidden_point(point, attribute, visible)) if point else None  # noqa: B023
        if read is not None:
            yield read


def _hidden_point(
    point: Any, attribute: Any, visible: Collection[str]
) -> tuple[str, Any, str] | None:
    component = component_id(point.component)
    if not component or component in visible:
        return None
    key = f"{HIDDEN_KEY}{component}/{point.component.name}/{point.name}"
    return key, point.nativeObject or point, str(attribute.value)


def read_hidden_points(
    design: Any, visible: Collection[str], notes: Notes
) -> Iterator[PointSnapshot]:
    """Yield the points of the add-in whose component has no occurrence, as lost points."""
    for key, point, text in hidden_points(design, visible):
        use = stored_point({POINT: text}, str(point.name), notes.findings)
        use = use or partial_use(_plain(text))
        if use is not None:
            use, why = without_occurrence(use, point.component)
            at = optional(lambda: position(point.geometry)) or (0.0, 0.0, 0.0)  # noqa: B023
            yield PointSnapshot(str(point.name), "", at, key, use, "", why)


def _positions(occurrence: Occurrence, native: Any, proxy: Any) -> tuple[Vector3, Vector3]:
    """Return the positions of a point in the frame of its component and in the root frame."""
    in_component = position(native.geometry)
    return in_component, occurrence.in_root(position(proxy.geometry), in_component)


def own_attributes(entity: Any) -> dict[str, str]:
    """Return the attributes of an entity in the group of the add-in, by name."""
    attributes = entity.attributes.itemsByGroup(GROUP)
    return dict(sorted((str(attribute.name), str(attribute.value)) for attribute in attributes))


def with_occurrence(
    use: Use, subject: Subject, path: str, places: Places, notes: Notes
) -> tuple[Use, str]:
    """Return a use with the occurrence of its stored place, and the reason if that is unknown."""
    scope = places.scope(path)
    if not (use.place or use.occurrence):
        return (replace(use, occurrence=scope) if path == scope else use), ""
    match = places.find(use.place, use.occurrence, scope, places.component(path))
    if match.is_moved:
        note_moved(subject, use.occurrence, match.path, notes)
    return replace(use, occurrence=match.path, place=()), match.lost


def without_occurrence(use: Use, component: Any) -> tuple[Use, str]:
    """Return the use of a point or face whose component has no occurrence, and the reason."""
    where = use.occurrence or str(component.name)
    is_copy = use.place and use.place[-1].component != component_id(component)
    why = copied(where) if is_copy else f"component {where!r} has no occurrence: {HIDDEN}"
    return replace(use, occurrence=where, place=()), why


def note_moved(subject: Subject, before: str, now: str, notes: Notes) -> None:
    """Report that a point or face follows its occurrence to another path."""
    message = (
        f"{subject.name!r} was stored on {before!r}, which is now {now!r}; press OK in Define "
        "muscles to store the new place"
    )
    if now == before:
        message = (
            f"{subject.name!r} was stored on another occurrence, which had the name {before!r}; "
            "check its position, and press OK in Define muscles to keep it"
        )
    notes.warn(subject, "moved-point", message)
