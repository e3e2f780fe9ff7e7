"""Writer of the table of muscles into the design, within one transaction.

The add-in makes construction points and attributes, and nothing else: a construction point of the
user is given a name and an attribute, and its own name back when it is no longer used.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from ...fusion.inserted import KEPT
from ...fusion.notes import optional
from ...fusion.occurrences import every_occurrence
from ...fusion.units import CM
from ...muscles.attributes import (
    GROUP,
    MUSCLES,
    POINT,
    POINTS,
    WRAP,
    kept_points_text,
    muscles_text,
    point_text,
    wrap_text,
)
from ...muscles.point_names import natural_key, parse_point_name
from ...muscles.rows import MuscleTable, ViaPointRow
from ...robot.errors import InputError
from ...robot.finding_builders import listed
from ...robot.model.robot import WORLD
from ...snapshot import SurfaceUse
from .desired_points import AnyRow, DesiredPoint, as_made, desired_points, original_name, rows_of
from .edits import About, added, is_called, native
from .free_points import delete_points, kept_point, make_points
from .picks import Picks, is_center, problem_of

_ASSEMBLY = 1  # DesignIntentTypes

TOLERANCE = 1e-6
"""How far a new point may be from where it was clicked, in [m]."""


class Writer:
    """Writes one table into one design."""

    def __init__(
        self,
        design: Any,
        picks: Picks,
        points: Mapping[str, Any],
        faces: Mapping[str, Any],
        link_of: Mapping[str, str],
    ) -> None:
        """A writer.

        Args:
            design: The design.
            picks: What the user has clicked.
            points: The construction points of the design, by what the snapshot calls them.
            faces: Its wrap faces, likewise.
            link_of: The link of each occurrence's path.
        """
        self._design = design
        self._picks = picks
        self._points = points
        self._faces = faces
        self._link_of = link_of
        self._occurrences = {o.fullPathName: o for o in every_occurrence(design.rootComponent)}

    def write(self, before: MuscleTable, after: MuscleTable) -> None:
        """Write the table into the design.

        Raises:
            InputError: Something cannot be written; the message says which object, and the
                transaction must be given up.
        """
        desired = []
        kept = []
        inserted = {row for row in rows_of(before) if self._is_inserted(row)}
        self._require_unchanged(inserted - set(rows_of(after)))
        for item in desired_points(after):
            if item.row in inserted:
                continue
            home = self._kept_at(item)
            if home is None:
                desired.append(item)
            else:
                kept.append(kept_point(as_made(item), self._occurrences.get(home), home))
        used = {row.entity for row in (*inserted, *(w.row for w in desired)) if row.entity}
        self._remove(before, used)
        points: list[Any] = []
        free: list[int] = []
        used = set()
        for i, item in enumerate(desired):
            point = self._points.get(item.row.entity)
            if point is None or item.row.entity in used:
                desired[i] = as_made(item)
                point = self._on_picked(item)
                if point is None:
                    free.append(i)
            else:
                desired[i] = self._with_origin(item, point)
            used.add(item.row.entity)
            points.append(point)
        for i, point in self._by_position([(i, desired[i]) for i in free]):
            points[i] = point
        self._name(list(zip(points, desired, strict=True)))
        self._write_faces(before, after)
        self._set(self._design, MUSCLES, muscles_text(after.rows), "the design")
        if kept or self._design.attributes.itemByName(GROUP, POINTS):
            self._set(self._design, POINTS, kept_points_text(kept), "the design")

    # Points

    def _is_inserted(self, row: AnyRow) -> bool:
        """Whether a point is stored in another document, and so read-only here."""
        if row.entity.startswith(KEPT):
            return not row.entity.startswith(f"{KEPT}/")
        return row.entity in self._points and bool(self._why_not(row))

    def _require_unchanged(self, rows: Iterable[AnyRow]) -> None:
        for row in rows:
            name = row.muscle if isinstance(row, ViaPointRow) else row.name
            raise InputError(f"a point of {name!r} cannot be written: {self._why_not(row)}")

    def _kept_at(self, item: DesiredPoint) -> str | None:
        """The occurrence that a point is kept at in the design; None if a component can hold it.

        Components of other documents are read-only here, and the root of an assembly design takes
        no points.
        """
        row = item.row
        if row.entity.startswith(KEPT):
            there = self._link_of.get(row.occurrence, WORLD) == row.link
            return row.occurrence if there else self._home(row)
        if row.entity in self._points:
            return None
        there = bool(row.entity) and self._link_of.get(row.occurrence, WORLD) == row.link
        home = row.occurrence if there else self._home(row)
        if not home:
            intent = optional(lambda: self._design.designIntent)
            return home if intent == _ASSEMBLY else None
        return home if problem_of(None, self._occurrences.get(home)) else None

    def _remove(self, before: MuscleTable, used: set[str]) -> None:
        gone = []
        for row in rows_of(before):
            point = self._points.get(row.entity)
            if row.entity in used or point is None:
                continue
            if row.made:
                gone.append((row, point))
                continue
            with About(f"construction point {point.name!r}", self._why_not(row)):
                attribute = point.attributes.itemByName(GROUP, POINT)
                original = original_name(attribute)
                if attribute:
                    attribute.deleteMe()
                if parse_point_name(point.name):  # it would be read as a point again
                    point.name = original or f"Unused {point.name}"
        if gone:
            why = next((why for row, _ in gone if (why := self._why_not(row))), "")
            names = listed([point.name for _, point in gone])
            with About(f"construction points {names}", why):
                delete_points([point for _, point in gone])

    def _name(self, points: list[tuple[Any, DesiredPoint]]) -> None:
        """Names and attributes; first, points give up names that others shall have."""
        changed = [(p, w) for p, w in points if not is_called(p, w.name)]
        names = {w.name for _, w in changed}
        for i, (point, w) in enumerate(changed):
            if point.name in names:
                with About(f"construction point {point.name!r}", self._why_not(w.row)):
                    point.name = f"cardsflow renames {i}"
        for point, w in points:
            with About(f"construction point {w.name!r}", self._why_not(w.row)):
                if not is_called(point, w.name):
                    point.name = w.name
            self._set(point, POINT, point_text(w.attribute), w.name, self._why_not(w.row))

    def _with_origin(self, item: DesiredPoint, point: Any) -> DesiredPoint:
        """The name that the user gave the point is remembered."""
        original = original_name(point.attributes.itemByName(GROUP, POINT))
        if not original and not item.row.made and not parse_point_name(point.name):
            original = point.name
        return replace(item, attribute=replace(item.attribute, original=original))

    def _on_picked(self, item: DesiredPoint) -> Any:
        """A new construction point on what was picked; None if that is of another link, or none."""
        row = item.row
        entity = self._picks.entity(row.entity)
        if entity is None or self._link_of.get(row.occurrence, WORLD) != row.link:
            return None
        with About(f"{item.name} on link {row.link!r}", self._why_not(row)):
            occurrence = self._occurrences.get(row.occurrence)
            component = occurrence.component if occurrence else self._design.rootComponent
            points = component.constructionPoints
            new = points.createInput(occurrence) if occurrence else points.createInput()
            set_by = new.setByCenter if is_center(entity) else new.setByPoint
            set_by(entity)
            return self._in_place(added(points, new), occurrence, row)

    def _by_position(self, items: list[tuple[int, DesiredPoint]]) -> Iterator[tuple[int, Any]]:
        """Where nothing of the design is: mirrored, read from a file, or of another link."""
        homes: dict[str, list[tuple[int, DesiredPoint]]] = {}
        for i, item in items:
            with About(f"{item.name} on link {item.row.link!r}", ""):
                homes.setdefault(self._home(item.row), []).append((i, item))
        for path, those in homes.items():
            occurrence = self._occurrences.get(path)
            component = occurrence.component if occurrence else self._design.rootComponent
            about = f"{listed([w.name for _, w in those])} on link {those[0][1].row.link!r}"
            with About(about, self._why_not(those[0][1].row)):
                positions = [item.row.position for _, item in those]
                made = make_points(self._design, component, occurrence, positions)
                for (i, item), point in zip(those, made, strict=True):
                    yield i, self._in_place(point, occurrence, item.row)

    def _in_place(self, point: Any, occurrence: Any, row: AnyRow) -> Any:
        """The point, if it is where it shall be: a wrong frame must not pass unseen."""
        seen = point.createForAssemblyContext(occurrence) if occurrence else point
        place = seen.geometry.x * CM, seen.geometry.y * CM, seen.geometry.z * CM
        if math.dist(place, row.position) > TOLERANCE:
            raise InputError(f"Fusion made it {1000 * math.dist(place, row.position):.3g} mm away")
        return point

    def _home(self, row: AnyRow) -> str:
        """Path of the occurrence whose component gets a point without an entity."""
        if row.link == WORLD or self._link_of.get("") == row.link:
            return ""
        if self._link_of.get(row.occurrence) == row.link and row.occurrence in self._occurrences:
            return row.occurrence
        paths = [p for p, link in self._link_of.items() if link == row.link]
        own = [p for p in paths if p in self._occurrences]
        if not own:
            raise InputError(f"link {row.link!r} has no component that could hold the point")
        writable = [p for p in own if not problem_of(None, self._occurrences[p])] or own
        return min(writable, key=lambda p: (p.count("+"), natural_key(p)))

    def _why_not(self, row: AnyRow) -> str:
        """What keeps the point of a row from being written, if anything is known to."""
        occurrence = self._occurrences.get(row.occurrence)
        if occurrence is None and not row.entity:
            paths = [p for p, link in self._link_of.items() if link == row.link and p]
            occurrence = self._occurrences.get(min(paths, default=""))
        return problem_of(None, occurrence)

    # Faces and attributes

    def _write_faces(self, before: MuscleTable, after: MuscleTable) -> None:
        kept = {wrap.entity for wrap in after.wraps}
        for wrap in before.wraps:
            face = self._faces.get(wrap.entity)
            if wrap.entity not in kept and face is not None:
                why = problem_of(None, self._occurrences.get(wrap.occurrence))
                with About(f"wrap surface {wrap.name!r}", why):
                    attribute = face.attributes.itemByName(GROUP, WRAP)
                    if attribute:
                        attribute.deleteMe()
        for wrap in after.wraps:
            why = problem_of(None, self._occurrences.get(wrap.occurrence))
            if why and wrap in before.wraps:  # of another document
                continue
            face = self._faces.get(wrap.entity) or native(self._picks.entity(wrap.entity))
            if face is None:
                problem = why or "its face is gone; pick it again"
                raise InputError(f"wrap surface {wrap.name!r}: {problem}")
            text = wrap_text(SurfaceUse(wrap.name, wrap.link, wrap.muscles, wrap.occurrence))
            self._set(face, WRAP, text, f"wrap surface {wrap.name!r}", why)

    def _set(self, owner: Any, name: str, text: str, about: str, why: str = "") -> None:
        """Set an attribute, if it has another text."""
        with About(about, why):
            attribute = owner.attributes.itemByName(GROUP, name)
            if attribute is None or attribute.value != text:
                owner.attributes.add(GROUP, name, text)
