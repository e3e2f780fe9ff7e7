"""Construction points of the add-in, identified by name or attributes, in every occurrence."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..muscles.attributes import GROUP, stored_point
from ..muscles.point_names import is_point_name
from ..robot.model.pose import Vector3
from ..snapshot import PointSnapshot
from .health import problem_of
from .names import Keys
from .notes import Notes
from .occurrences import Occurrence, each_in, subject_in
from .units import position


def read_points(occurrence: Occurrence, keys: Keys, notes: Notes) -> Iterator[PointSnapshot]:
    """Yield the points in an occurrence."""
    component = occurrence.component
    found = []
    for native, name, proxy in each_in(
        occurrence, lambda: component.constructionPoints, notes, "point"
    ):
        subject = subject_in(occurrence, "point", name)
        held = notes.attempt(subject, "attributes", own_attributes, native)
        if not held and not is_point_name(name):
            continue
        problem = notes.attempt(subject, "state", problem_of, native, subject, notes)
        read = notes.attempt(subject, "position", _positions, occurrence, native, proxy)
        if read is not None:
            use = stored_point(held or {}, name, notes.findings)
            found.append((name, read, use, problem or ""))
    count: dict[str, int] = {}
    # Sorted by position in the component, which is the same in every occurrence.
    for name, (_, there), use, problem in sorted(found, key=lambda point: (point[0], point[1][0])):
        number = count[name] = count.get(name, -1) + 1
        yield PointSnapshot(
            name, occurrence.path, there, keys.key(occurrence, name, number), use, problem
        )


def _positions(occurrence: Occurrence, native: Any, proxy: Any) -> tuple[Vector3, Vector3]:
    """Return the positions of a point in the frame of its component and in the root frame."""
    own = position(native.geometry)
    return own, occurrence.in_root(position(proxy.geometry), own)


def own_attributes(entity: Any) -> dict[str, str]:
    """Return the attributes of an entity in the group of the add-in, by name."""
    attributes = entity.attributes.itemsByGroup(GROUP)
    return dict(sorted((str(attribute.name), str(attribute.value)) for attribute in attributes))
