"""Rigid groups of an occurrence, with the full paths of their members."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from ...muscles.point_names import natural_key
from ...snapshot import GroupSnapshot
from ..health import problem_of
from ..notes import Notes, items, optional
from ..occurrences import Occurrence, Occurrences, name_of, path_of, subject_in


def read_groups(
    occurrence: Occurrence, occurrences: Occurrences, notes: Notes
) -> Iterator[GroupSnapshot]:
    """Yield the rigid groups of the component of an occurrence."""
    component = occurrence.component
    for native in items(lambda: component.rigidGroups, notes, occurrence.subject, "groups"):
        name = optional(lambda: name_of(native))  # noqa: B023 -- called at once
        if name is None:
            _note_stale(occurrence, notes)
            continue
        subject = subject_in(occurrence, "group", name)
        group = notes.attempt(subject, "place", occurrence.proxy, native)
        if group is None:
            continue
        problem = notes.attempt(subject, "state", problem_of, native, subject, notes)
        if problem:
            message = f"group {name!r}: {problem}. Edit the group, or delete it"
            notes.warn(subject, "group-problem", message)
        suppressed = notes.attempt(subject, "state", lambda g: bool(g.isSuppressed), group)
        paths = set()
        for member in items(partial(getattr, group, "occurrences"), notes, subject, "members"):
            path = notes.attempt(subject, "members", path_of, member)
            if path is None:
                continue
            # The path may be relative to the occurrence of the group instead of the root.
            below = f"{occurrence.path}+{path}"
            existing = next((p for p in (path, below) if p in occurrences), None)
            if existing is not None:
                paths.add(existing)
            elif not suppressed:
                message = (
                    f"group {name!r} contains {path!r}, which is not in the design: edit the group "
                    "and choose its components again"
                )
                notes.warn(subject, "unknown-member", message)
        yield GroupSnapshot(name, tuple(sorted(paths, key=natural_key)), bool(suppressed))


def _note_stale(occurrence: Occurrence, notes: Notes) -> None:
    """Warn of a group whose name cannot be read: it is obsolete and has no members."""
    where = occurrence.path or "the root component"
    message = (
        f"{where} has rigid groups without components, which have no effect. Delete them in the "
        "browser, under Joints"
    )
    notes.warn(occurrence.subject, "stale-group", message)
