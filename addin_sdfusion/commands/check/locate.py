"""Entities of the design that a finding is about."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any

from ...fusion.notes import optional
from ...fusion.occurrences import readable_occurrences
from ...robot.finding import Subject
from ...snapshot import LINK_PREFIX, bare_name
from ..reading import Reading

_MAX_ENTITIES = 50


def entities_of(design: Any, reading: Reading, subject: Subject) -> list[Any]:
    """Return the entities to select for a finding; empty if none is visible."""
    find = _Locator(design, reading).finders.get(subject.kind)
    return [] if find is None else list(islice(find(subject.name), _MAX_ENTITIES))


class _Locator:
    """Search for entities of a design by the names used in findings."""

    def __init__(self, design: Any, reading: Reading) -> None:
        self._occurrences = readable_occurrences(design.rootComponent)
        self._reading = reading
        self.finders: dict[str, Callable[[str], Iterable[Any]]] = {
            "link": self._link,
            "occurrence": self._occurrence,
            "component": self._occurrence,
            "joint": self._joint,
            "coordinate": self._coordinate,
            "group": self._group,
            "body": self._body,
            "point": self._point,
            "muscle": self._muscle,
            "task_frame": self._frame,
            "marker": self._frame,
        }

    def _link(self, name: str) -> Iterator[Any]:
        for path, occurrence in self._occurrences.items():
            if path and self._reading.link_of.get(path) == name:
                yield occurrence.native

    def _occurrence(self, name: str) -> Iterator[Any]:
        for path, occurrence in self._occurrences.items():
            if path and name in (path, occurrence.native.name, occurrence.component.name):
                yield occurrence.native

    def _joint(self, name: str) -> list[Any]:
        return [joint for joint in self._joints() if joint.name in (name, LINK_PREFIX + name)]

    def _coordinate(self, name: str) -> list[Any]:
        """Return the joint of a coordinate, such as `shoulder` for `shoulder_pitch`."""
        return self._joint(name) or [
            j for j in self._joints() if name.startswith(f"{bare_name(j.name)}_")
        ]

    def _joints(self) -> Iterator[Any]:
        for occurrence in self._occurrences.values():
            for joints in (occurrence.component.joints, occurrence.component.asBuiltJoints):
                for i in range(joints.count):
                    yield occurrence.proxy(joints.item(i))

    def _group(self, name: str) -> Iterator[Any]:
        for occurrence in self._occurrences.values():
            groups = occurrence.component.rigidGroups
            for i in range(groups.count):
                group = groups.item(i)
                if optional(lambda: group.name) in (name, LINK_PREFIX + name):  # noqa: B023
                    yield from group.occurrences

    def _body(self, name: str) -> Iterator[Any]:
        path, _, body_name = name.rpartition("/")
        occurrence = self._occurrences.get(path)
        if occurrence is not None:
            for bodies in (occurrence.component.bRepBodies, occurrence.component.meshBodies):
                for i in range(bodies.count):
                    if bodies.item(i).name == body_name:
                        yield occurrence.proxy(bodies.item(i))

    def _point(self, name: str) -> Iterator[Any]:
        points = self._reading.snapshot.points
        return self._points({(p.occurrence, p.name) for p in points if p.name == name})

    def _muscle(self, name: str) -> Iterator[Any]:
        points = self._reading.table.points_of(name.rpartition("/")[2])
        return self._points_of({(p.entity, p.occurrence) for p in points})

    def _frame(self, name: str) -> Iterator[Any]:
        names = {"task": name.rpartition("/")[2], "marker": name}
        others = self._reading.table.others
        return self._points_of(
            {(p.entity, p.occurrence) for p in others if p.name == names[p.role]}
        )

    def _points_of(self, keys: set[tuple[str, str]]) -> Iterator[Any]:
        """Yield construction points by their entity and occurrence in the snapshot."""
        points = self._reading.snapshot.points
        return self._points(
            {(p.occurrence, p.name) for p in points if (p.entity, p.occurrence) in keys}
        )

    def _points(self, names: set[tuple[str, str]]) -> Iterator[Any]:
        """Yield construction points by occurrence and name."""
        for path, occurrence in self._occurrences.items():
            points = occurrence.component.constructionPoints
            for i in range(points.count):
                if (path, points.item(i).name) in names:
                    yield occurrence.proxy(points.item(i))
