"""Builders of findings, shared by all checks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from .errors import UnknownNameError
from .finding import Finding, Subject


def error(subject: Subject, code: str, problem: str) -> Finding:
    """An error; its message begins with the subject."""
    return Finding("error", code, f"{label(subject)}: {problem}", subject)


def warning(subject: Subject, code: str, problem: str) -> Finding:
    """A warning; its message begins with the subject."""
    return Finding("warning", code, f"{label(subject)}: {problem}", subject)


def label(subject: Subject) -> str:
    """The subject for a message, such as `task frame 'tip'`."""
    return f"{subject.kind.replace('_', ' ')} {subject.name!r}"


MOST_NAMES_COMPARED = 200
"""With more names the nearest one is not looked for: the time would grow with their square."""


def unknown(kind: str, name: str, known: Sequence[str]) -> str:
    """The text that there is no such name, with the nearest one."""
    if len(known) > MOST_NAMES_COMPARED:
        return f"no {kind} {name!r} among the {len(known)} known"
    return UnknownNameError(kind, name, known).what


def finite(values: Iterable[float]) -> bool:
    """Whether all values are numbers and none is infinite."""
    return all(map(math.isfinite, values))
