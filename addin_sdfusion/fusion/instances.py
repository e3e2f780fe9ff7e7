"""Muscles of inserted designs, in every place that a design is inserted at.

A design names its muscles, points, links and occurrences for itself. In the design that it is
inserted into, muscles of a name that is there already get a number, points are on the links of
their own occurrences, and paths begin at the root.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ..muscles.attributes import stored_muscles
from ..robot.finding import Subject
from ..robot.model.robot import WORLD
from ..snapshot import MuscleSnapshot, PointSnapshot, SurfaceSnapshot
from .inserted import Held
from .names import free_name
from .notes import Notes


class Instances:
    """The muscles of all designs, and what their points and surfaces are in the open one.

    Attributes:
        muscles: Of the open design, then of those inserted into it.
    """

    def __init__(self, held: Held, design: str, notes: Notes) -> None:
        """Muscles as designs list them.

        Args:
            held: What the designs store.
            design: Name of the open design.
            notes: Takes what is wrong, and which muscles are called otherwise.
        """
        own, *inserted = (
            (path, stored_muscles(attributes, path or design, notes.findings))
            for path, attributes in held
        )
        self._listed = {path: {m.name for m in listed} for path, listed in inserted if listed}
        self._given: dict[tuple[str, str, str], str] = {}
        self._taken: dict[str, set[str]] = {"muscle": set().union(*self._listed.values())}
        known = {m.name for m in own[1]}
        found = dict[str, MuscleSnapshot]()
        for path, listed in inserted:
            for muscle in listed:
                name = self._name("muscle", muscle.name, path)
                found[name] = replace(muscle, name=name)
                if name != muscle.name:
                    message = _renamed(path, muscle.name, name)
                    notes.warn(Subject("muscle", muscle.name), "same-name", message)
        self.muscles = (*own[1], *(m for name, m in found.items() if name not in known))

    def point(self, point: PointSnapshot, design: str | None = None) -> PointSnapshot:
        """Return a point as the open design has it.

        Args:
            point: As its design has it.
            design: Path that this design is inserted at; that of the nearest one if None.
        """
        path = self._inserted_at(point.occurrence) if design is None else design
        use = point.use
        if path not in self._listed or use is None:
            return point
        if use.role == "via" and use.muscle not in self._listed[path]:
            return point
        own = use.muscle if use.role == "via" else use.name or point.name
        name = self._name("muscle" if use.role == "via" else use.role, own, path)
        named = replace(use, muscle=name) if use.role == "via" else replace(use, name=name)
        placed = replace(named, link=_link(use.link), occurrence=_joined(path, use.occurrence))
        return replace(point, use=placed, entity=_entity(point.entity, path, name != own))

    def surface(self, surface: SurfaceSnapshot) -> SurfaceSnapshot:
        """Return a wrap surface as the open design has it."""
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
        where = _joined(path, use.occurrence)
        use = replace(use, name=name, link=_link(use.link), muscles=muscles, occurrence=where)
        return replace(surface, use=use, entity=entity)

    def _inserted_at(self, occurrence: str) -> str | None:
        """Path of the nearest design with muscles around an occurrence; None for the open one."""
        return next((path for path in _above(occurrence) if path in self._listed), None)

    def _name(self, kind: str, name: str, path: str) -> str:
        """What a muscle, point or surface of a design is called here: the first keeps its name."""
        key = kind, name, path
        if key not in self._given:
            taken = self._taken.setdefault(kind, set())
            is_first = not any(k[:2] == key[:2] for k in self._given)
            self._given[key] = name if is_first else free_name(name, taken)
            taken.add(self._given[key])
        return self._given[key]


def _renamed(path: str, name: str, new: str) -> str:
    return (
        f"muscle {name!r} of the design inserted as {path!r} is called {new!r} in the robot: there "
        "is one of that name already"
    )


def _above(occurrence: str) -> Iterator[str]:
    """A path and those above it, the longest first."""
    while occurrence:
        yield occurrence
        occurrence = occurrence.rpartition("+")[0]


def _link(own: str) -> str:
    """Return links have other names in the open design: that of the occurrence counts."""
    return own if own == WORLD else ""


def _joined(path: str, below: str) -> str:
    return f"{path}+{below}" if below else ""


def _entity(entity: str, path: str, is_another: bool) -> str:
    return f"{entity}@{path}" if entity and is_another else entity
