"""Writer for the muscle table of a design, in one transaction.

The add-in creates only construction points and attributes. It renames construction points of the
user that it uses, and restores the original name of a point that is no longer used.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from ...fusion.inserted import KEPT
from ...fusion.notes import Notes, optional
from ...fusion.occurrences import find_occurrences
from ...fusion.places import Places
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
    read_wrap,
    without_tokens,
    wrap_text,
)
from ...muscles.point_names import (
    marker_name,
    motor_numbers,
    natural_key,
    parse_point_name,
    task_point_name,
    via_point_name,
)
from ...muscles.table import MuscleTable, PointRow, WrapRow
from ...robot.errors import InputError
from ...robot.finding_builders import listed
from ...robot.model.robot import WORLD
from ...snapshot import PointUse
from .construction_points import (
    ErrorContext,
    added,
    delete_points,
    has_name,
    kept_point,
    make_points,
    native,
)
from .picks import Picks, is_center, problem_of
from .stored_lists import StoredLists, update_attribute

_ASSEMBLY = 1  # DesignIntentTypes

TOLERANCE = 1e-6
"""Maximum distance of a new point from the clicked position, in [m]."""


@dataclass(frozen=True)
class Desired:
    """A row of the table with the name of its construction point."""

    row: PointRow
    name: str

    def as_made(self) -> Desired:
        """Return the row marked as a point that the add-in created."""
        return replace(self, row=replace(self.row, made=True, original=""))


class Writer:
    """Writer of one table into one design."""

    def __init__(
        self,
        design: Any,
        picks: Picks,
        points: Mapping[str, Any],
        faces: Mapping[str, Any],
        link_of: Mapping[str, str],
    ) -> None:
        """Create a writer.

        Args:
            design: The design.
            picks: Picked entities.
            points: Construction points of the design, by their keys in the snapshot.
            faces: Wrap faces of the design, by their keys in the snapshot.
            link_of: Link of each occurrence, by path.
        """
        self._design = design
        self._picks = picks
        self._points = points
        self._faces = faces
        self._link_of = link_of
        found = find_occurrences(design.rootComponent, Notes(lambda _: None))
        self._places = Places(design, found)
        self._occurrences = {p: o.native for p, o in found.items() if p}
        self._lists = StoredLists(design)
        self._original: dict[str, str] = {}  # original names of construction points

    def write(self, before: MuscleTable, after: MuscleTable) -> None:
        """Write the table into the design.

        Raises:
            InputError: An object cannot be written. The message contains its name, and the caller
                must abort the transaction.
        """
        desired: list[Desired] = []
        kept = []
        lost: list[PointRow] = []
        self._original = {row.entity: row.original for row in _rows(before)}
        inserted = {row for row in _rows(before) if self._is_inserted(row)}
        self._require_unchanged(inserted - set(_rows(after)))
        for item in _desired_points(after):
            if item.row in inserted:
                continue
            if item.row.lost:
                lost.append(item.row)
                continue
            home = self._storage_occurrence(item)
            if home is None:
                desired.append(item)
            else:
                row = replace(item.as_made().row, occurrence=home)
                stored = kept_point(row, self._occurrences.get(home), home)
                kept.append(replace(stored, use=self._use(row)))
        used = {row.entity for row in (*inserted, *lost, *(w.row for w in desired)) if row.entity}
        self._remove(before, used)
        points: list[Any] = []
        free: list[int] = []
        used = set()
        for i, item in enumerate(desired):
            point = self._points.get(item.row.entity)
            if point is None or item.row.entity in used:
                desired[i] = item.as_made()
                point = self._create_on_entity(item)
                if point is None:
                    free.append(i)
            else:
                desired[i] = self._with_origin(item, point)
            used.add(item.row.entity)
            points.append(point)
        for i, point, path in self._create_at_positions([(i, desired[i]) for i in free]):
            points[i] = point
            desired[i] = replace(desired[i], row=replace(desired[i].row, occurrence=path))
        self._name(list(zip(points, desired, strict=True)))
        self._write_faces(before, after)
        self._update_lost(before, lost)
        unread = self._lists.unread_muscles(
            {row.name for row in before.rows} - {row.name for row in after.rows}
        )
        self._set(self._design, MUSCLES, muscles_text(after.rows, unread), "the design")
        items = self._lists.unread_points({row.entity for row in _rows(before)}, lost)
        if kept or items or self._design.attributes.itemByName(GROUP, POINTS):
            self._set(self._design, POINTS, kept_points_text(kept, items), "the design")
        self._lists.keep_texts()

    # Points

    def _use(self, row: PointRow) -> PointUse:
        """Return the use to store: the link only if it is not the link of the occurrence."""
        own = self._link_of.get(row.occurrence, "" if row.occurrence else WORLD)
        link = "" if row.link == own else row.link
        return replace(row.use, link=link, place=self._places.of(row.occurrence))

    def _update_lost(self, before: MuscleTable, lost: Iterable[PointRow]) -> None:
        """Store new numbers and muscles of lost points, whose records are otherwise unchanged."""
        stored = set(_rows(before))
        for row in lost:
            point = self._points.get(row.entity)
            if row not in stored and point is not None:
                with ErrorContext(f"construction point {point.name!r}", self._write_problem(row)):
                    update_attribute(point, POINT, row.use)

    def _is_inserted(self, row: PointRow) -> bool:
        """Return whether a point is stored in another document and is therefore read-only."""
        if row.entity.startswith(KEPT):
            return not row.entity.startswith(f"{KEPT}/")
        return row.entity in self._points and bool(self._write_problem(row))

    def _require_unchanged(self, rows: Iterable[PointRow]) -> None:
        for row in rows:
            problem = self._write_problem(row)
            raise InputError(f"a point of {row.muscle or row.name!r} cannot be written: {problem}")

    def _storage_occurrence(self, item: Desired) -> str | None:
        """Return the occurrence of a point that must be stored in the design; else None.

        Components of other documents are read-only, and the root of an assembly design cannot
        contain points.
        """
        row = item.row
        if row.entity.startswith(KEPT):
            is_on_link = self._link_of.get(row.occurrence, WORLD) == row.link
            return row.occurrence if is_on_link else self._target_occurrence(row)
        if row.entity in self._points:
            return None
        is_on_link = bool(row.entity) and self._link_of.get(row.occurrence, WORLD) == row.link
        home = row.occurrence if is_on_link else self._target_occurrence(row)
        if not home:
            intent = optional(lambda: self._design.designIntent)
            return home if intent == _ASSEMBLY else None
        return home if problem_of(None, self._occurrences.get(home)) else None

    def _remove(self, before: MuscleTable, used: set[str]) -> None:
        gone = []
        for row in _rows(before):
            point = self._points.get(row.entity)
            if row.entity in used or point is None:
                continue
            if row.made:
                gone.append((row, point))
                continue
            with ErrorContext(f"construction point {point.name!r}", self._write_problem(row)):
                attribute = point.attributes.itemByName(GROUP, POINT)
                if attribute:
                    attribute.deleteMe()
                if parse_point_name(
                    point.name
                ):  # otherwise the name would be read as a point again
                    point.name = row.original or f"Unused {point.name}"
        if gone:
            why = next((why for row, _ in gone if (why := self._write_problem(row))), "")
            names = listed([point.name for _, point in gone])
            with ErrorContext(f"construction points {names}", why):
                delete_points([point for _, point in gone])

    def _name(self, points: list[tuple[Any, Desired]]) -> None:
        """Set names and attributes; first rename points whose current name is needed by others."""
        changed = [(p, w) for p, w in points if not has_name(p, w.name)]
        names = {w.name for _, w in changed}
        for i, (point, w) in enumerate(changed):
            if point.name in names:
                with ErrorContext(f"construction point {point.name!r}", self._write_problem(w.row)):
                    point.name = f"cardsflow temporary {i}"
        for point, w in points:
            with ErrorContext(f"construction point {w.name!r}", self._write_problem(w.row)):
                if not has_name(point, w.name):
                    point.name = w.name
            text = point_text(self._use(w.row))
            self._set(point, POINT, text, w.name, self._write_problem(w.row))

    def _with_origin(self, item: Desired, point: Any) -> Desired:
        """Return the row with the original name of the point."""
        row = item.row
        original = self._original.get(row.entity, "")
        if not original and not row.made and not parse_point_name(point.name):
            original = point.name
        return replace(item, row=replace(row, original=original))

    def _create_on_entity(self, item: Desired) -> Any:
        """Create a construction point on the picked entity.

        Returns None if no entity was picked or if it belongs to another link.
        """
        row = item.row
        entity = self._picks.entity(row.entity)
        if entity is None or self._link_of.get(row.occurrence, WORLD) != row.link:
            return None
        with ErrorContext(f"{item.name} on link {row.link!r}", self._write_problem(row)):
            occurrence = self._occurrences.get(row.occurrence)
            component = occurrence.component if occurrence else self._design.rootComponent
            points = component.constructionPoints
            new = points.createInput(occurrence) if occurrence else points.createInput()
            set_by = new.setByCenter if is_center(entity) else new.setByPoint
            set_by(entity)
            return self._require_position(added(points, new), occurrence, row)

    def _create_at_positions(
        self, items: list[tuple[int, Desired]]
    ) -> Iterator[tuple[int, Any, str]]:
        """Create points at coordinates: mirrored, imported, or moved to another link.

        Yields index, point and path of the occurrence.
        """
        homes: dict[str, list[tuple[int, Desired]]] = {}
        for i, item in items:
            with ErrorContext(f"{item.name} on link {item.row.link!r}", ""):
                homes.setdefault(self._target_occurrence(item.row), []).append((i, item))
        for path, those in homes.items():
            occurrence = self._occurrences.get(path)
            component = occurrence.component if occurrence else self._design.rootComponent
            about = f"{listed([w.name for _, w in those])} on link {those[0][1].row.link!r}"
            with ErrorContext(about, self._write_problem(those[0][1].row)):
                positions = [item.row.position for _, item in those]
                made = make_points(self._design, component, occurrence, positions)
                for (i, item), point in zip(those, made, strict=True):
                    yield i, self._require_position(point, occurrence, item.row), path

    def _require_position(self, point: Any, occurrence: Any, row: PointRow) -> Any:
        """Return the point if it has the desired position, which detects a wrong frame."""
        seen = point.createForAssemblyContext(occurrence) if occurrence else point
        place = seen.geometry.x * CM, seen.geometry.y * CM, seen.geometry.z * CM
        if math.dist(place, row.position) > TOLERANCE:
            apart = 1000 * math.dist(place, row.position)
            raise InputError(f"Fusion created it {apart:.3g} mm away from its position")
        return point

    def _target_occurrence(self, row: PointRow) -> str:
        """Return the path of the occurrence whose component gets a point without an entity."""
        if row.link == WORLD or self._link_of.get("") == row.link:
            return ""
        if self._link_of.get(row.occurrence) == row.link and row.occurrence in self._occurrences:
            return row.occurrence
        paths = [p for p, link in self._link_of.items() if link == row.link]
        own = [p for p in paths if p in self._occurrences]
        if not own:
            raise InputError(f"link {row.link!r} has no component that can contain the point")
        writable = [p for p in own if not problem_of(None, self._occurrences[p])] or own
        return min(writable, key=lambda p: (p.count("+"), natural_key(p)))

    def _write_problem(self, row: PointRow) -> str:
        """Return the known reason why the point of a row cannot be written, or an empty string."""
        occurrence = self._occurrences.get(row.occurrence)
        if occurrence is None and not row.entity:
            paths = [p for p, link in self._link_of.items() if link == row.link and p]
            occurrence = self._occurrences.get(min(paths, default=""))
        return problem_of(None, occurrence)

    # Faces and attributes

    def _write_faces(self, before: MuscleTable, after: MuscleTable) -> None:
        kept = {wrap.face.entity for wrap in after.wraps}
        for wrap in before.wraps:
            face = self._faces.get(wrap.face.entity)
            if wrap.face.entity not in kept and face is not None:
                why = problem_of(None, self._occurrences.get(wrap.occurrence))
                with ErrorContext(f"wrap surface {wrap.name!r}", why):
                    attribute = face.attributes.itemByName(GROUP, WRAP)
                    if attribute:
                        attribute.deleteMe()
        for wrap in after.wraps:
            why = problem_of(None, self._occurrences.get(wrap.occurrence))
            if wrap.lost or (why and wrap in before.wraps):  # not found, or of another document
                self._update_lost_wrap(wrap, before)
                continue
            key = wrap.face.entity
            face = self._faces.get(key) or native(self._picks.entity(key))
            if face is None:
                problem = why or "its face does not exist any more; pick it again"
                raise InputError(f"wrap surface {wrap.name!r}: {problem}")
            own = self._link_of.get(wrap.occurrence, "" if wrap.occurrence else WORLD)
            place = self._places.of(wrap.occurrence)
            link = "" if wrap.link == own else wrap.link
            use = replace(wrap.use, link=link, place=place)
            self._set(face, WRAP, wrap_text(use), f"wrap surface {wrap.name!r}", why)

    def _update_lost_wrap(self, wrap: WrapRow, before: MuscleTable) -> None:
        face = self._faces.get(wrap.face.entity)
        if wrap not in before.wraps and face is not None:
            with ErrorContext(f"wrap surface {wrap.name!r}", ""):
                attribute = face.attributes.itemByName(GROUP, WRAP)
                stored = read_wrap(attribute.value)
                use = replace(stored, name=wrap.name, muscles=wrap.muscles)
                face.attributes.add(GROUP, WRAP, wrap_text(use))

    def _set(self, owner: Any, name: str, text: str, about: str, why: str = "") -> None:
        """Set an attribute if its text changes."""
        with ErrorContext(about, why):
            attribute = owner.attributes.itemByName(GROUP, name)
            if attribute is None or without_tokens(attribute.value) != without_tokens(text):
                owner.attributes.add(GROUP, name, text)


def _rows(table: MuscleTable) -> tuple[PointRow, ...]:
    """Return the rows of all points."""
    return *table.points, *table.others


def _desired_points(table: MuscleTable) -> Iterator[Desired]:
    """Yield the rows of all points with the names of their construction points."""
    motors = motor_numbers(row.name for row in table.rows)
    for p in table.points:
        yield Desired(p, via_point_name(motors[p.muscle], p.link, p.number))
    for p in table.others:
        name = task_point_name if p.role == "task" else marker_name
        yield Desired(p, name(p.link))
