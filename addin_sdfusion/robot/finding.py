"""Findings of checks: one a defect."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

Severity = Literal["error", "warning"]

_MAX_MESSAGE = 2000
"""Characters of a message: what it quotes of a file may be as long as the file."""


def cut(message: str, most: int = _MAX_MESSAGE) -> str:
    """Return a message without the end that nobody reads."""
    return message if len(message) <= most else f"{message[:most]} ..."


class Subject(NamedTuple):
    """The object that a finding is about.

    Attributes:
        kind: `robot`, `link`, `joint`, `coordinate`, `cable_set`, `muscle`, `task_set` or
            `task_frame`.
        name: Its name. A muscle of another than the active cable set is `set/muscle`; a task frame
            of another than the active task set is `set/frame`.
    """

    kind: str
    name: str


@dataclass(frozen=True, slots=True)
class Finding:
    """Something wrong, or doubtful, in a robot or its files.

    Attributes:
        severity: `error` (the robot cannot be used) or `warning`.
        code: A short stable identifier, such as `zero-inertia-about-axis`.
        message: One sentence: what is wrong and what to do.
        subject: The object concerned.
        file: The file it comes from, if known.
        line: The line in that file, counted from 1, if known.
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

    def __str__(self) -> str:
        """`file:line: severity: message [code]`, in one line."""
        place = "" if self.file is None else str(self.file)
        if place and self.line is not None:
            place += f":{self.line}"
        what = f"{self.severity}: {cut(self.message)} [{self.code}]"
        return f"{place}: {what}" if place else what


def errors_first(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings in their order, but errors before warnings."""
    return sorted(findings, key=lambda finding: not finding.is_error)


def member(kind: str, name: str, of: str, active: str) -> Subject:
    """Return the subject for a member of a set: `name` in the active set, `set/name` in another.

    Args:
        kind: `muscle` or `task_frame`.
        name: The member's name.
        of: The name of the set that holds it.
        active: The name of the active set.
    """
    return Subject(kind, name if of == active else f"{of}/{name}")
