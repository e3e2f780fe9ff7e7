"""Muscles of inserted designs, for every occurrence of an inserted design.

Names in an inserted design are relative to that design. In the open design, muscles with a
duplicate name get a numeric suffix, and points belong to the links of their occurrences.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ..muscles.stored import stored_muscles
from ..robot.finding import Subject
from ..robot.model.robot import WORLD
from ..snapshot import MuscleSnapshot, PointSnapshot, SurfaceSnapshot
from .inserted import DesignAttributes
from .names import free_name
from .notes import Notes


class Instances:
    """Muscles, points and wrap surfaces of all designs, converted to the open design.

    Attributes:
        muscles: Muscles of the open design, then of the inserted designs.
    """

    def __init__(self, of_designs: DesignAttributes, design: str, notes: Notes) -> None:
        """Read the lists of muscles of all designs."""
        (_, of_open_design), *inserted = (
            (path, stored_muscles(attributes, path or design, notes.findings))
            for path, attributes in of_designs
        )
        self._listed = {path: {m.name for m in listed} for path, listed in inserted if listed}
        self._unique: dict[tuple[str, str, str], str] = {}
        self._used: dict[str, set[str]] = {"muscle": set().union(*self._listed.values())}
        names = {m.name for m in of_open_design}
        by_name = dict[str, MuscleSnapshot]()
        for path, listed in inserted:
            for muscle in listed:
                name = self._name("muscle", muscle.name, path)
                by_name[name] = replace(muscle, name=name)
                if name != muscle.name:
                    message = _rename_message(path, muscle.name, name)
                    notes.warn(Subject("muscle", muscle.name), "same-name", message)
        self.muscles = (
            *of_open_design,
            *(m for name, m in by_name.items() if name not in names),
        )

    def point(self, point: PointSnapshot, design: str | None = None) -> PointSnapshot:
        """Return a point with names of the open design.

        Args:
            point: Point with names of its own design.
            design: Path of the inserted design; None for the nearest one.
        """
        path = self._inserted_at(point.occurrence) if design is None else design
        use = point.use
        if path not in self._listed or use is None:
            return point
        if use.role == "via" and use.muscle not in self._listed[path]:
            return point
        stored_name = use.muscle if use.role == "via" else use.name or point.name
        name = self._name("muscle" if use.role == "via" else use.role, stored_name, path)
        named = replace(use, muscle=name) if use.role == "via" else replace(use, name=name)
        placed = replace(named, link=_link(use.link))
        return replace(point, use=placed, entity=_entity(point.entity, path, name != stored_name))

    def surface(self, surface: SurfaceSnapshot) -> SurfaceSnapshot:
        """Return a wrap surface with names of the open design."""
        path, use = self._inserted_at(surface.occurrence), surface.use
        if path is None or use is None:
            return surface
        if self._listed[path].isdisjoint(wrap.muscle for wrap in use.muscles):
            return surface
        name = self._name("surface", use.name, path)
        muscles = tuple(
            replace(wrap, muscle=self._name("muscle", wrap.muscle, path)) for wrap in use.muscles
        )
        entity = _entity(surface.entity, path, name != use.name)
        use = replace(use, name=name, link=_link(use.link), muscles=muscles)
        return replace(surface, use=use, entity=entity)

    def _inserted_at(self, occurrence: str) -> str | None:
        """Return the path of the nearest inserted design with muscles, or None."""
        return next((path for path in _ancestors(occurrence) if path in self._listed), None)

    def _name(self, kind: str, name: str, path: str) -> str:
        """Return the unique name of a muscle, point or surface; the first one keeps its name."""
        key = kind, name, path
        if key not in self._unique:
            used = self._used.setdefault(kind, set())
            is_first = not any(k[:2] == key[:2] for k in self._unique)
            self._unique[key] = name if is_first else free_name(name, used)
            used.add(self._unique[key])
        return self._unique[key]


def _rename_message(path: str, name: str, new: str) -> str:
    return (
        f"muscle {name!r} of the design inserted as {path!r} is called {new!r} in the robot, since "
        "this name exists already"
    )


def _ancestors(occurrence: str) -> Iterator[str]:
    """Yield a path and the paths of its ancestors, the longest first."""
    while occurrence:
        yield occurrence
        occurrence = occurrence.rpartition("+")[0]


def _link(link: str) -> str:
    """Return the link of a point in the open design; empty for the link of the occurrence.

    Links of an inserted design have other names in the open design.
    """
    return link if link == WORLD else ""


def _entity(entity: str, path: str, is_another: bool) -> str:
    return f"{entity}@{path}" if entity and is_another else entity
