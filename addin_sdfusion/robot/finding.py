"""Findings of checks: errors and warnings."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

Severity = Literal["error", "warning"]

_MAX_MESSAGE = 2000
"""Maximum number of characters of a message, since text quoted from a file may be very long."""


def truncate(message: str, length: int = _MAX_MESSAGE) -> str:
    """Return a message, short_repr to a maximum number of characters."""
    return message if len(message) <= length else f"{message[:length]} ..."


class Subject(NamedTuple):
    """The object that a finding is about.

    Attributes:
        kind: `robot`, `link`, `joint`, `coordinate`, `cable_set`, `muscle`, `task_set` or
            `task_frame`.
        name: Name of the object. Muscles of inactive cable sets are `set/muscle`, task frames of
            inactive task sets `set/frame`.
    """

    kind: str
    name: str


@dataclass(frozen=True, slots=True)
class Finding:
    """An error or a warning about a robot or its files.

    Attributes:
        severity: `error` (the robot cannot be used) or `warning`.
        code: Short, stable identifier, such as `zero-inertia-about-axis`.
        message: One sentence with the problem and its solution.
        subject: The object with the problem.
        file: File that defines the object, if known.
        line: Line in that file, counted from 1, if known.
    """

    severity: Severity
    code: str
    message: str
    subject: Subject
    file: Path | None = None
    line: int | None = None

    @property
    def is_error(self) -> bool:
        """Whether the robot cannot be used because of this."""
        return self.severity == "error"

    def as_dict(self) -> dict[str, str | int | None]:
        """Return the finding as plain data, for JSON."""
        return {
            "severity": self.severity,
            "code": self.code,
            "message": self.message,
            "kind": self.subject.kind,
            "name": self.subject.name,
            "file": None if self.file is None else str(self.file),
            "line": self.line,
        }

    @property
    def located(self) -> str:
        """The message, after the file and the line if they are known."""
        return f"{self._place}{truncate(self.message)}"

    @property
    def _place(self) -> str:
        if self.file is None:
            return ""
        return f"{self.file}: " if self.line is None else f"{self.file}:{self.line}: "

    def __str__(self) -> str:
        """Return `file:line: severity: message [code]` as one line."""
        return f"{self._place}{self.severity}: {truncate(self.message)} [{self.code}]"


def errors_first(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings with errors before warnings, otherwise in their order."""
    return sorted(findings, key=lambda finding: not finding.is_error)


def member(kind: str, name: str, of: str, active: str) -> Subject:
    """Return the subject for a member of a set: `name` in the active set, `set/name` in another.

    Args:
        kind: `muscle` or `task_frame`.
        of: Name of the set that contains the member.
        active: Name of the active set.
    """
    return Subject(kind, name if of == active else f"{of}/{name}")
