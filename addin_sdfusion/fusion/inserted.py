"""Data that designs keep next to their construction points, those of inserted designs included.

A design that is inserted into another brings its muscles; points on components of other documents
are kept in the design that these are put into, each in the frame of its occurrence.
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
"""How the entities of kept points begin."""

Held = list[tuple[str, Mapping[str, str]]]
"""Attributes of designs, by the path that they are inserted at; the first is the open one."""


def attributes_of_designs(own: Mapping[str, str], occurrences: Occurrences) -> Held:
    """What the open design and those inserted into it store."""
    held: Held = [("", own)]
    for occurrence in occurrences.values():
        if occurrence.native is not None and _is_inserted(occurrence, occurrences):
            found = optional(lambda: own_attributes(occurrence.component.parentDesign))  # noqa: B023
            if found:
                held.append((occurrence.path, found))
    return held


def _is_inserted(occurrence: Occurrence, occurrences: Occurrences) -> bool:
    """Return whether a document begins here: the component is of another one than what holds it."""
    above = occurrences.get(occurrence.parent)
    designs = (
        optional(lambda: occurrence.component.parentDesign),
        optional(lambda: None if above is None else above.component.parentDesign),
    )
    return designs[0] is not None and designs[0] != designs[1]


def read_kept(
    held: Held, occurrences: Occurrences, notes: Notes
) -> Iterator[tuple[str, PointSnapshot]]:
    """The points that designs keep, each with the path that its design is inserted at."""
    for path, attributes in held:
        for number, kept in enumerate(_kept(path, attributes, notes)):
            at = "+".join(part for part in (path, kept.occurrence) if part)
            name = kept.use.name or f"{kept.use.muscle} {kept.use.number}"
            occurrence = occurrences.get(at)
            if occurrence is None:
                message = (
                    f"{kept.use.role} point {name!r} is kept relative to {at!r}, which is not in "
                    "the design; pick it again in Define muscles"
                )
                notes.warn(Subject("point", name), "lost-point", message)
                continue
            entity = f"{KEPT}{path}/{number}"
            place = occurrence.T.apply(kept.position)
            yield path, PointSnapshot(name, at, place, entity, kept.use)


def _kept(path: str, attributes: Mapping[str, str], notes: Notes) -> tuple[KeptPoint, ...]:
    try:
        return read_kept_points(attributes.get(POINTS, "[]"))
    except InputError as error:
        subject = Subject("design", path or "root")
        message = f"the points that the design keeps cannot be read ({error}); pick them again"
        notes.add("error", subject, "bad-attribute", message)
        return ()
