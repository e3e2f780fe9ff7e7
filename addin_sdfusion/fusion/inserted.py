"""Attributes of the open design and of the designs inserted into it.

The attributes of an inserted design define its muscles. Points on components of other documents
are stored in the design that contains these components, in the frame of the occurrence.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from ..muscles.attributes import POINTS, KeptPoint, partial_use, read_kept_point, read_list
from ..robot.errors import InputError
from ..robot.finding import Subject
from ..snapshot import KEPT, PointSnapshot, PointUse
from .notes import Notes, optional
from .occurrences import Occurrences
from .places import Places
from .points import note_moved, own_attributes

DesignAttributes = list[tuple[str, Mapping[str, str]]]
"""Path of the occurrence and attributes of each design; the first is the open design."""


def attributes_of_designs(
    attributes: Mapping[str, str], occurrences: Occurrences, places: Places
) -> DesignAttributes:
    """Return the attributes of the open design and of all inserted designs."""
    of_designs: DesignAttributes = [("", attributes)]
    for path, occurrence in occurrences.items():
        if places.is_inserted(path):
            inserted = optional(lambda: own_attributes(occurrence.component.parentDesign))  # noqa: B023
            if inserted:
                of_designs.append((path, inserted))
    return of_designs


def read_kept(
    of_designs: DesignAttributes, occurrences: Occurrences, places: Places, notes: Notes
) -> Iterator[tuple[str, PointSnapshot]]:
    """Yield the points that are stored in designs, with the path of the inserted design.

    Records that cannot be read are yielded as lost points if their muscle is known.
    """
    for path, attributes in of_designs:
        for number, plain in enumerate(_stored_items(path, attributes, notes)):
            entity = f"{KEPT}{path}/{number}"
            where = f"{POINTS}[{number}]"
            try:
                record = read_kept_point(plain, where)
            except InputError as error:
                subject = Subject("design", path or "root")
                message = f"a point stored in the design cannot be read ({error}); it is kept"
                notes.add("error", subject, "bad-attribute", message)
                use = partial_use(plain.get("use") if isinstance(plain, dict) else None)
                if use is not None:
                    why = f"its record cannot be read ({error})"
                    yield path, PointSnapshot(_name(use), "", (0.0, 0.0, 0.0), entity, use, "", why)
                continue
            yield path, _kept_point(record, path, entity, occurrences, places, notes)


def _kept_point(
    record: KeptPoint,
    path: str,
    entity: str,
    occurrences: Occurrences,
    places: Places,
    notes: Notes,
) -> PointSnapshot:
    match = places.find(record.use.place, record.occurrence, path)
    name = _name(record.use)
    use = replace(record.use, occurrence=match.path, place=())
    if match.lost:
        return PointSnapshot(name, match.path, record.position, entity, use, "", match.lost)
    if match.is_moved:
        note_moved(Subject("point", name), record.occurrence, match.path, notes)
    place = occurrences[match.path].T.apply(record.position)
    return PointSnapshot(name, match.path, place, entity, use)


def _name(use: PointUse) -> str:
    return use.name or f"{use.muscle} {use.number}"


def _stored_items(path: str, attributes: Mapping[str, str], notes: Notes) -> list[Any]:
    try:
        return read_list(attributes.get(POINTS, "[]"), POINTS)
    except InputError as error:
        subject = Subject("design", path or "root")
        message = (
            f"the points stored in the design cannot be read ({error}); pick them again in Define "
            "muscles, which keeps the stored text"
        )
        notes.add("error", subject, "bad-attribute", message)
        return []
