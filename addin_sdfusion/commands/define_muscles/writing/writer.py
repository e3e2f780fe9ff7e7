"""Writer for the muscle table of a design, in one transaction.

The add-in creates only construction points and attributes. It renames construction points of the
user that it uses, and restores the original name of a point that is no longer used.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from ....fusion.handles import Handles
from ....fusion.units import position
from ....muscles.attributes import (
    GROUP,
    MUSCLES,
    POINT,
    POINTS,
    KeptPoint,
    kept_points_text,
    muscles_text,
    point_text,
)
from ....muscles.point_names import (
    marker_name,
    motor_numbers,
    parse_point_name,
    task_point_name,
    via_point_name,
)
from ....muscles.rows import PointRow
from ....muscles.table import MuscleTable
from ....robot.errors import InputError
from ....robot.finding_builders import listed
from ..entities import Entities
from ..model.model import MuscleModel
from ..picks import is_on_body
from .construction_points import (
    ErrorContext,
    added,
    delete_points,
    has_name,
    kept_point,
    make_points,
    set_attribute,
)
from .faces import write_faces
from .homes import Homes
from .stored_lists import StoredLists, update_attribute

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

    def __init__(self, design: Any, entities: Entities, model: MuscleModel) -> None:
        self._design = design
        self._entities = entities
        self._points = entities.points
        self._model = model
        self._homes = Homes(design, model.link_of, entities.points)
        self._lists = StoredLists(design)
        self._original = {row.entity: row.original for row in _rows(model.before)}

    def write(self) -> None:
        """Write the table into the design.

        Raises:
            InputError: An object cannot be written. The message contains its name, and the caller
                must abort the transaction.
        """
        before, after = self._model.before, self._model.table
        desired: list[Desired] = []
        stored: list[KeptPoint] = []
        lost: list[PointRow] = []
        inserted = {row for row in _rows(before) if self._homes.is_inserted(row)}
        self._require_unchanged(inserted - set(_rows(after)))
        for item in _desired_points(after):
            if item.row in inserted:
                continue
            if item.row.lost:
                lost.append(item.row)
                continue
            home = self._homes.storage(item.row)
            if home is None:
                desired.append(item)
            else:
                stored.append(self._kept_point(replace(item.as_made().row, occurrence=home)))
        used = {row.entity for row in (*inserted, *lost, *(w.row for w in desired)) if row.entity}
        self._remove(before, used)
        self._write_points(desired)
        write_faces(self._model, self._entities, self._homes)
        self._update_lost(before, lost)
        self._write_lists(stored, lost)

    def _write_lists(self, stored: list[KeptPoint], lost: list[PointRow]) -> None:
        """Write the list of muscles and the list of points that are stored in the design."""
        before, after = self._model.before, self._model.table
        deleted = {row.name for row in before.rows} - {row.name for row in after.rows}
        text = muscles_text(after.rows, self._lists.unread_muscles(deleted))
        set_attribute(self._design, MUSCLES, text, "the design")
        items = self._lists.unread_points({row.entity for row in _rows(before)}, lost)
        if stored or items or self._design.attributes.itemByName(GROUP, POINTS):
            set_attribute(self._design, POINTS, kept_points_text(stored, items), "the design")
        self._lists.keep_texts()

    def _kept_point(self, row: PointRow) -> KeptPoint:
        """Return a point to store in the design."""
        home = self._homes.occurrences.get(row.occurrence)
        return replace(kept_point(row, home, row.occurrence), use=self._homes.use(row))

    # Points

    def _write_points(self, desired: list[Desired]) -> None:
        """Create, name and number the construction points."""
        points = Handles(self._design)
        free: list[int] = []
        used: set[str] = set()
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
            points[i] = point
        for i, point, path in self._create_at_positions([(i, desired[i]) for i in free]):
            points[i] = point
            desired[i] = replace(desired[i], row=replace(desired[i].row, occurrence=path))
        self._name([(points.get(i), item) for i, item in enumerate(desired)])

    def _update_lost(self, before: MuscleTable, lost: Iterable[PointRow]) -> None:
        """Store new numbers and muscles of lost points, whose records are otherwise unchanged."""
        stored = set(_rows(before))
        for row in lost:
            point = self._points.get(row.entity)
            if row not in stored and point is not None:
                with ErrorContext(f"construction point {point.name!r}", self._homes.problem(row)):
                    update_attribute(point, POINT, row.use)

    def _require_unchanged(self, rows: Iterable[PointRow]) -> None:
        for row in rows:
            problem = self._homes.problem(row)
            raise InputError(f"a point of {row.muscle or row.name!r} cannot be written: {problem}")

    def _remove(self, before: MuscleTable, used: set[str]) -> None:
        deleted_points = []
        for row in _rows(before):
            point = self._points.get(row.entity)
            if row.entity in used or point is None:
                continue
            if row.made:
                deleted_points.append((row, point))
                continue
            with ErrorContext(f"construction point {point.name!r}", self._homes.problem(row)):
                attribute = point.attributes.itemByName(GROUP, POINT)
                if attribute:
                    attribute.deleteMe()
                if parse_point_name(
                    point.name
                ):  # otherwise the name would be read as a point again
                    point.name = row.original or f"Unused {point.name}"
        if deleted_points:
            why = next((why for row, _ in deleted_points if (why := self._homes.problem(row))), "")
            names = listed([point.name for _, point in deleted_points])
            with ErrorContext(f"construction points {names}", why):
                delete_points([point for _, point in deleted_points])

    def _name(self, points: list[tuple[Any, Desired]]) -> None:
        """Set names and attributes; first rename points whose current name is needed by others."""
        changed = [(p, w) for p, w in points if not has_name(p, w.name)]
        names = {w.name for _, w in changed}
        for i, (point, w) in enumerate(changed):
            if point.name in names:
                with ErrorContext(f"construction point {point.name!r}", self._homes.problem(w.row)):
                    point.name = f"cardsflow temporary {i}"
        for point, w in points:
            with ErrorContext(f"construction point {w.name!r}", self._homes.problem(w.row)):
                if not has_name(point, w.name):
                    point.name = w.name
            text = point_text(self._homes.use(w.row))
            set_attribute(point, POINT, text, w.name, self._homes.problem(w.row))

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
        entity = self._entities.picked.get(row.entity)
        if entity is None or not self._homes.is_on_link(row):
            return None
        with ErrorContext(f"{item.name} on link {row.link!r}", self._homes.problem(row)):
            occurrence = self._homes.occurrences.get(row.occurrence)
            points = self._homes.component(row.occurrence).constructionPoints
            new = points.createInput(occurrence) if occurrence else points.createInput()
            set_by = new.setByCenter if is_on_body(entity) else new.setByPoint
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
                homes.setdefault(self._homes.target(item.row), []).append((i, item))
        for path, those in homes.items():
            occurrence = self._homes.occurrences.get(path)
            component = self._homes.component(path)
            about = f"{listed([w.name for _, w in those])} on link {those[0][1].row.link!r}"
            with ErrorContext(about, self._homes.problem(those[0][1].row)):
                positions = [item.row.position for _, item in those]
                points = make_points(self._design, component, occurrence, positions)
                for (i, item), point in zip(those, points, strict=True):
                    yield i, self._require_position(point, occurrence, item.row), path

    def _require_position(self, point: Any, occurrence: Any, row: PointRow) -> Any:
        """Return the point if it has the desired position, which detects a wrong frame."""
        seen = point.createForAssemblyContext(occurrence) if occurrence else point
        place = position(seen.geometry)
        if math.dist(place, row.position) > TOLERANCE:
            apart = 1000 * math.dist(place, row.position)
            raise InputError(f"Fusion created it {apart:.3g} mm away from its position")
        return point


def _rows(table: MuscleTable) -> tuple[PointRow, ...]:
    return *table.points, *table.others


def _desired_points(table: MuscleTable) -> Iterator[Desired]:
    """Yield the rows of all points with the names of their construction points."""
    motors = motor_numbers(row.name for row in table.rows)
    for p in table.points:
        yield Desired(p, via_point_name(motors[p.muscle], p.link, p.number))
    for p in table.others:
        name = task_point_name if p.role == "task" else marker_name
        yield Desired(p, name(p.link))
