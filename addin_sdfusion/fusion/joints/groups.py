"""Rigid groups of an occurrence, with their members' paths from the root."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from ...muscles.point_names import natural_key
from ...snapshot import GroupSnapshot
from ..notes import Notes, items
from ..occurrences import Occurrence, Occurrences, each_in, path_of, subject_in


def read_groups(
    occurrence: Occurrence, occurrences: Occurrences, notes: Notes
) -> Iterator[GroupSnapshot]:
    """The rigid groups of the component in an occurrence."""
    component = occurrence.component
    for _, name, group in each_in(occurrence, lambda: component.rigidGroups, notes, "group"):
        subject = subject_in(occurrence, "group", name)
        suppressed = notes.attempt(subject, "state", _is_suppressed, group)
        paths = set()
        for member in items(partial(_members, group), notes, subject, "members"):
            path = notes.attempt(subject, "members", path_of, member)
            if path is None:
                continue
            # Below the occurrence of the group, in case the path is not from the root.
            below = f"{occurrence.path}+{path}"
            known = next((p for p in (path, below) if p in occurrences), None)
            if known is not None:
                paths.add(known)
            elif not suppressed:
                message = (
                    f"group {name!r} holds {path!r}, which is not in the design: edit the group "
                    "and choose its components again"
                )
                notes.warn(subject, "unknown-member", message)
        yield GroupSnapshot(name, tuple(sorted(paths, key=natural_key)), bool(suppressed))


def _is_suppressed(group: Any) -> bool:
    return bool(group.isSuppressed)


def _members(group: Any) -> Any:
    return group.occurrences
