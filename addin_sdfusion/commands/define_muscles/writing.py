"""Writer of the table of muscles into the design, within one transaction.

The add-in makes construction points and attributes, and nothing else: a construction point of the
user is given a name and an attribute, and its own name back when it is no longer used.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import adsk.core
import adsk.fusion

from ...fusion.units import CM
from ...muscles.attributes import (
    GROUP,
    MUSCLES,
    POINT,
    WRAP,
    muscles_text,
    point_text,
    wrap_text,
)
from ...muscles.point_names import natural_key, parse_point_name
from ...muscles.rows import MuscleTable
from ...robot.errors import InputError
from ...robot.model.robot import WORLD
from ...snapshot import SurfaceUse
from .desired_points import AnyRow, DesiredPoint, as_made, desired_points, original_name, rows_of
from .edits import About, added, base_feature, delete, is_called, native
from .picks import Picks, is_center, problem_of

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
        self._occurrences = {o.fullPathName: o for o in design.rootComponent.allOccurrences}

    def write(self, before: MuscleTable, after: MuscleTable) -> None:
        """Write the table into the design.

        Raises:
            InputError: Something cannot be written; the message says which object, and the
                transaction must be given up.
        """
        desired = list(desired_points(after))
        self._remove(before, {w.row.entity for w in desired if w.row.entity})
        kept: list[tuple[Any, DesiredPoint]] = []
        used: set[str] = set()
        for item in desired:
            point = self._points.get(item.row.entity)
            if point is None or item.row.entity in used:
                point = self._made(item)
                item = as_made(item)
            else:
                item = self._with_origin(item, point)
            used.add(item.row.entity)
            kept.append((point, item))
        self._name(kept)
        self._write_faces(before, after)
        self._set(self._design, MUSCLES, muscles_text(after.rows), "the design")

    # Points

    def _remove(self, before: MuscleTable, used: set[str]) -> None:
        for row in rows_of(before):
            point = self._points.get(row.entity)
            if row.entity in used or point is None:
                continue
            with About(f"construction point {point.name!r}", self._why_not(row)):
                if row.made:
                    delete(point)
                    continue
                attribute = point.attributes.itemByName(GROUP, POINT)
                original = original_name(attribute)
                if attribute:
                    attribute.deleteMe()
                if parse_point_name(point.name):  # it would be read as a point again
                    point.name = original or f"Unused {point.name}"

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

    def _made(self, item: DesiredPoint) -> Any:
        """A new construction point, in the link's component."""
        row = item.row
        entity = self._picks.entity(row.entity)
        with About(f"{item.name} on link {row.link!r}", self._why_not(row)):
            picked_in_link = self._link_of.get(row.occurrence, WORLD) == row.link
            if entity is not None and picked_in_link:
                return self._on_entity(entity, row)
            return self._by_position(row)

    def _on_entity(self, entity: Any, row: AnyRow) -> Any:
        occurrence = self._occurrences.get(row.occurrence)
        component = occurrence.component if occurrence else self._design.rootComponent
        points = component.constructionPoints
        new = points.createInput(occurrence) if occurrence else points.createInput()
        set_by = new.setByCenter if is_center(entity) else new.setByPoint
        set_by(entity)
        return self._in_place(added(points, new), occurrence, row)

    def _by_position(self, row: AnyRow) -> Any:
        """Where nothing of the design is: mirrored, read from a file, or of another link."""
        occurrence = self._home(row)
        component = occurrence.component if occurrence else self._design.rootComponent
        place = adsk.core.Point3D.create(*(v / CM for v in row.position))
        if occurrence:
            to_component = occurrence.transform2.copy()
            to_component.invert()
            place.transformBy(to_component)
        points = component.constructionPoints
        new = points.createInput()
        new.setByPoint(place)
        if self._design.designType == adsk.fusion.DesignTypes.DirectDesignType:
            return self._in_place(added(points, new), occurrence, row)
        feature = base_feature(component)
        new.targetBaseOrFormFeature = feature
        feature.startEdit()
        try:
            made = added(points, new)
        finally:
            feature.finishEdit()
        return self._in_place(made, occurrence, row)

    def _in_place(self, point: Any, occurrence: Any, row: AnyRow) -> Any:
        """The point, if it is where it shall be: a wrong frame must not pass unseen."""
        seen = point.createForAssemblyContext(occurrence) if occurrence else point
        place = seen.geometry.x * CM, seen.geometry.y * CM, seen.geometry.z * CM
        if math.dist(place, row.position) > TOLERANCE:
            raise InputError(f"Fusion made it {1000 * math.dist(place, row.position):.3g} mm away")
        return point

    def _home(self, row: AnyRow) -> Any:
        """The occurrence whose component gets a point without an entity; None for the root."""
        if row.link == WORLD or self._link_of.get("") == row.link:
            return None
        if self._link_of.get(row.occurrence) == row.link and row.occurrence in self._occurrences:
            return self._occurrences[row.occurrence]
        paths = [p for p, link in self._link_of.items() if link == row.link]
        own = [p for p in paths if p in self._occurrences]
        if not own:
            raise InputError(f"link {row.link!r} has no component that could hold the point")
        writable = [p for p in own if not problem_of(None, self._occurrences[p])] or own
        return self._occurrences[min(writable, key=lambda p: (p.count("+"), natural_key(p)))]

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
            face = self._faces.get(wrap.entity) or native(self._picks.entity(wrap.entity))
            if face is None:
                raise InputError(f"wrap surface {wrap.name!r}: its face is gone; pick it again")
            text = wrap_text(SurfaceUse(wrap.name, wrap.link, wrap.muscles, wrap.occurrence))
            why = problem_of(None, self._occurrences.get(wrap.occurrence))
            self._set(face, WRAP, text, f"wrap surface {wrap.name!r}", why)

    def _set(self, owner: Any, name: str, text: str, about: str, why: str = "") -> None:
        """Set an attribute, if it has another text."""
        with About(about, why):
            attribute = owner.attributes.itemByName(GROUP, name)
            if attribute is None or attribute.value != text:
                owner.attributes.add(GROUP, name, text)
