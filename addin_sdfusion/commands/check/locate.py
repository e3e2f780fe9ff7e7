"""Entities of the design that a finding is about."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...robot.finding import Subject
from ..reading import Reading

_PREFIX = "EXPORT_"
_MOST = 50


def entities_of(design: Any, reading: Reading, subject: Subject) -> list[Any]:
    """What to select for a finding; empty if it is about nothing that can be seen."""
    found = _FINDERS.get(subject.kind, _nothing)(design, reading, subject.name)
    return [entity for _, entity in zip(range(_MOST), found, strict=False)]


def _nothing(design: Any, reading: Reading, name: str) -> Iterator[Any]:
    yield from ()


def _occurrences(design: Any) -> dict[str, Any]:
    return {o.fullPathName: o for o in design.rootComponent.allOccurrences}


def _link(design: Any, reading: Reading, name: str) -> Iterator[Any]:
    for path, occurrence in _occurrences(design).items():
        if reading.link_of.get(path) == name:
            yield occurrence


def _occurrence(design: Any, reading: Reading, name: str) -> Iterator[Any]:
    for path, occurrence in _occurrences(design).items():
        if name in (path, occurrence.name, occurrence.component.name):
            yield occurrence


def _joint(design: Any, reading: Reading, name: str) -> Iterator[Any]:
    for joint in _joints(design):
        if joint.name in (name, _PREFIX + name):
            yield joint


def _coordinate(design: Any, reading: Reading, name: str) -> Iterator[Any]:
    """The joint of a coordinate: `shoulder`, or `shoulder_pitch` of several."""
    found = list(_joint(design, reading, name))
    if not found:
        for joint in _joints(design):
            if name.startswith(f"{joint.name.removeprefix(_PREFIX)}_"):
                found.append(joint)
    yield from found


def _joints(design: Any) -> Iterator[Any]:
    for component, occurrence in _places(design):
        for joints in (component.joints, component.asBuiltJoints):
            for i in range(joints.count):
                yield _seen(joints.item(i), occurrence)


def _group(design: Any, reading: Reading, name: str) -> Iterator[Any]:
    for component, _ in _places(design):
        for i in range(component.rigidGroups.count):
            group = component.rigidGroups.item(i)
            if group.name in (name, _PREFIX + name):
                yield from group.occurrences


def _body(design: Any, reading: Reading, name: str) -> Iterator[Any]:
    path, _, own = name.rpartition("/")
    for component, occurrence in _places(design):
        if (occurrence.fullPathName if occurrence else "") == path:
            for bodies in (component.bRepBodies, component.meshBodies):
                for i in range(bodies.count):
                    if bodies.item(i).name == own:
                        yield _seen(bodies.item(i), occurrence)


def _points(design: Any, names: set[tuple[str, str]]) -> Iterator[Any]:
    """Construction points by occurrence and name."""
    for component, occurrence in _places(design):
        path = occurrence.fullPathName if occurrence else ""
        for i in range(component.constructionPoints.count):
            point = component.constructionPoints.item(i)
            if (path, point.name) in names:
                yield _seen(point, occurrence)


def _point(design: Any, reading: Reading, name: str) -> Iterator[Any]:
    points = reading.snapshot.points
    yield from _points(design, {(p.occurrence, p.name) for p in points if p.name == name})


def _muscle(design: Any, reading: Reading, name: str) -> Iterator[Any]:
    keys = {(p.entity, p.occurrence) for p in reading.table.points_of(name.rpartition("/")[2])}
    yield from _points_of(design, reading, keys)


def _points_of(design: Any, reading: Reading, keys: set[tuple[str, str]]) -> Iterator[Any]:
    """Construction points by entity and occurrence, as the snapshot calls them."""
    points = reading.snapshot.points
    names = {(p.occurrence, p.name) for p in points if (p.entity, p.occurrence) in keys}
    yield from _points(design, names)


def _frame(design: Any, reading: Reading, name: str) -> Iterator[Any]:
    own, table = name.rpartition("/")[2], reading.table
    keys = {(t.entity, t.occurrence) for t in table.tasks if t.name == own}
    keys |= {(m.entity, m.occurrence) for m in table.markers if m.name == name}
    yield from _points_of(design, reading, keys)


def _places(design: Any) -> Iterator[tuple[Any, Any]]:
    """Every component in every place; the root's place is None."""
    yield design.rootComponent, None
    for occurrence in design.rootComponent.allOccurrences:
        yield occurrence.component, occurrence


def _seen(entity: Any, occurrence: Any) -> Any:
    return entity.createForAssemblyContext(occurrence) if occurrence else entity


_FINDERS = {
    "link": _link,
    "occurrence": _occurrence,
    "component": _occurrence,
    "joint": _joint,
    "coordinate": _coordinate,
    "group": _group,
    "body": _body,
    "point": _point,
    "muscle": _muscle,
    "task_frame": _frame,
    "marker": _frame,
}
