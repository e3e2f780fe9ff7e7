"""Occurrences and components that store the points of a muscle table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ....fusion.handles import Handles
from ....fusion.notes import optional
from ....fusion.occurrences import readable_occurrences
from ....fusion.places import Places
from ....muscles.point_names import natural_key
from ....muscles.rows import PointRow, WrapRow
from ....robot.errors import InputError
from ....robot.model.robot import WORLD
from ....snapshot import KEPT, PointUse, SurfaceUse
from ..picks import problem_of

_ASSEMBLY = 1  # DesignIntentTypes


class Homes:
    """Occurrences of a design in which points are stored.

    Attributes:
        occurrences: Occurrences that can be read, by path.
    """

    def __init__(self, design: Any, link_of: Mapping[str, str], points: Handles) -> None:
        """Read the occurrences of a design.

        Args:
            link_of: Link of each occurrence, by path.
            points: Construction points of the design, by their keys in the snapshot.
        """
        self._design = design
        self._link_of = link_of
        self._points = points
        occurrences = readable_occurrences(design.rootComponent)
        self._places = Places(design, occurrences)
        self.occurrences: dict[str, Any] = {p: o.native for p, o in occurrences.items() if p}

    def component(self, path: str) -> Any:
        """Return the component of an occurrence, or the root component."""
        occurrence = self.occurrences.get(path)
        return occurrence.component if occurrence else self._design.rootComponent

    def use(self, row: PointRow) -> PointUse:
        """Return the use to store: the link only if it is not the link of the occurrence."""
        link = self._stored_link(row)
        return replace(row.use, link=link, place=self._places.of(row.occurrence))

    def surface_use(self, wrap: WrapRow) -> SurfaceUse:
        """Return the use of a face to store."""
        link = self._stored_link(wrap)
        return replace(wrap.use, link=link, place=self._places.of(wrap.occurrence))

    def _stored_link(self, row: PointRow | WrapRow) -> str:
        link_of_occurrence = self._link_of.get(row.occurrence, "" if row.occurrence else WORLD)
        return "" if row.link == link_of_occurrence else row.link

    def is_on_link(self, row: PointRow) -> bool:
        """Return whether the link of a point is the link of its occurrence."""
        return self._link_of.get(row.occurrence, WORLD) == row.link

    def is_inserted(self, row: PointRow) -> bool:
        """Return whether a point is stored in another document and is therefore read-only."""
        if row.entity.startswith(KEPT):
            return not row.entity.startswith(f"{KEPT}/")
        return row.entity in self._points and bool(self.problem(row))

    def storage(self, row: PointRow) -> str | None:
        """Return the occurrence of a point that must be stored in the design; else None.

        Components of other documents are read-only, and the root of an assembly design cannot
        contain points.
        """
        if row.entity.startswith(KEPT):
            return row.occurrence if self.is_on_link(row) else self.target(row)
        if row.entity in self._points:
            return None
        is_picked = bool(row.entity) and self.is_on_link(row)
        home = row.occurrence if is_picked else self.target(row)
        if not home:
            intent = optional(lambda: self._design.designIntent)
            return home if intent == _ASSEMBLY else None
        return home if problem_of(None, self.occurrences.get(home)) else None

    def target(self, row: PointRow) -> str:
        """Return the path of the occurrence whose component gets a point without an entity."""
        if row.link == WORLD or self._link_of.get("") == row.link:
            return ""
        if self._link_of.get(row.occurrence) == row.link and row.occurrence in self.occurrences:
            return row.occurrence
        paths = [p for p, link in self._link_of.items() if link == row.link]
        usable = [p for p in paths if p in self.occurrences]
        if not usable:
            raise InputError(f"link {row.link!r} has no component that can contain the point")
        writable = [p for p in usable if not problem_of(None, self.occurrences[p])] or usable
        return min(writable, key=lambda p: (p.count("+"), natural_key(p)))

    def problem(self, row: PointRow) -> str:
        """Return the known reason why the point of a row cannot be written, or an empty string."""
        occurrence = self.occurrences.get(row.occurrence)
        if occurrence is None and not row.entity:
            paths = [p for p, link in self._link_of.items() if link == row.link and p]
            occurrence = self.occurrences.get(min(paths, default=""))
        return problem_of(None, occurrence)
