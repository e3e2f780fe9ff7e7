"""Functions that create findings and their texts, for all checks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from .errors import UnknownNameError
from .finding import Finding, Subject, member
from .model.muscle import Muscle
from .model.robot import Robot, TaskFrame


def error(subject: Subject, code: str, problem: str) -> Finding:
    """Return an error finding; its message begins with the subject."""
    return Finding("error", code, f"{label(subject)}: {problem}", subject)


def warning(subject: Subject, code: str, problem: str) -> Finding:
    """Return a warning finding; its message begins with the subject."""
    return Finding("warning", code, f"{label(subject)}: {problem}", subject)


def label(subject: Subject) -> str:
    """Return the subject for a message, such as `task frame 'tip'`."""
    return f"{subject.kind.replace('_', ' ')} {subject.name!r}"


MAX_NAMES_COMPARED = 100
"""With more names no similar name is searched, since the time grows with the number squared."""


def unknown(kind: str, name: str, known: Sequence[str]) -> str:
    """Return the message for an unknown name, with the most similar known name."""
    if len(known) > MAX_NAMES_COMPARED:
        return f"no {kind} {name!r} among the {len(known)} known"
    return UnknownNameError(kind, name, known).problem


def listed(names: Sequence[str], most: int = 10) -> str:
    """Return the quoted names, separated by commas; names after the first `most` become `...`."""
    return ", ".join(map(repr, names[:most])) + (", ..." if len(names) > most else "")


def all_muscles(robot: Robot) -> Iterator[tuple[Subject, Muscle]]:
    """Yield the muscles of every cable set, with the subjects of their findings."""
    for group in robot.cable_sets:
        for muscle in group.muscles:
            yield member("muscle", muscle.name, group.name, robot.cable_set), muscle


def all_task_frames(robot: Robot) -> Iterator[tuple[Subject, TaskFrame]]:
    """Yield the frames of every operational space, with the subjects of their findings."""
    for group in robot.task_sets:
        for frame in group.frames:
            yield member("task_frame", frame.name, group.name, robot.task_set), frame


def finite(values: Iterable[float]) -> bool:
    """Return whether all values are finite."""
    return all(map(math.isfinite, values))
