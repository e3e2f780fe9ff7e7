"""Attributes of the open design and of the designs inserted into it.

The attributes of an inserted design define its muscles. Points on components of other documents
are stored in the design that contains these components, in the frame of the occurrence.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..muscles.attributes import POINTS, KeptPoint, read_kept_points
from ..robot.errors import InputError
from ..robot.finding import Subject
from ..snapshot import PointSnapshot
from .notes import Notes, optional
from .occurrences import Occurrence, Occurrences
from .points import own_attributes

KEPT = "kept:"
"""Prefix of the entities of points that are stored in a design."""

Held = list[tuple[str, Mapping[str, str]]]
"""Path of the occurrence and attributes of each design; the first is the open design."""


def attributes_of_designs(own: Mapping[str, str], occurrences: Occurrences) -> Held:
    """Return the attributes of the open design and of all inserted designs."""
    held: Held = [("", own)]
    for occurrence in occurrences.values():
        if occurrence.native is not None and _is_inserted(occurrence, occurrences):
            found = optional(lambda: own_attributes(occurrence.component.parentDesign))  # noqa: B023
            if found:
                held.append((occurrence.path, found))
    return held


def _is_inserted(occurrence: Occurrence, occurrences: Occurrences) -> bool:
    """Return whether the component of an occurrence belongs to another document than its parent."""
    above = occurrences.get(occurrence.parent)
    designs = (
        optional(lambda: occurrence.component.parentDesign),
        optional(lambda: None if above is None else above.component.parentDesign),
    )
    return designs[0] is not None and designs[0] != designs[1]


def read_kept(
    held: Held, occurrences: Occurrences, notes: Notes
) -> Iterator[tuple[str, PointSnapshot]]:
    """Yield the points that are stored in designs, with the path of the inserted design."""
    for path, attributes in held:
        for number, kept in enumerate(_stored_points(path, attributes, notes)):
            at = "+".join(part for part in (path, kept.occurrence) if part)
            name = kept.use.name or f"{kept.use.muscle} {kept.use.number}"
            occurrence = occurrences.get(at)
            if occurrence is None:
                message = (
                    f"{kept.use.role} point {name!r} is stored relative to {at!r}, which is not "
                    "in the design; pick it again in Define muscles"
                )
                notes.warn(Subject("point", name), "lost-point", message)
                continue
            entity = f"{KEPT}{path}/{number}"
            place = occurrence.T.apply(kept.position)
            yield path, PointSnapshot(name, at, place, entity, kept.use)


def _stored_points(path: str, attributes: Mapping[str, str], notes: Notes) -> tuple[KeptPoint, ...]:
    try:
        return read_kept_points(attributes.get(POINTS, "[]"))
    except InputError as error:
        subject = Subject("design", path or "root")
        message = f"the points stored in the design cannot be read ({error}); pick them again"
        notes.add("error", subject, "bad-attribute", message)
        return ()
