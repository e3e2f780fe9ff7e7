"""Findings on unreadable parts of a design, with traces for the log."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from ..progress import Cancelled
from ..robot.finding import Finding, Severity, Subject

Log = Callable[[str], None]
Result = TypeVar("Result")

REPAIR = "Repair it in Fusion (Modify > Compute All shows what is broken) or delete it"
"""Advice for most things that cannot be read."""


class Notes:
    """Collects findings while a design is read.

    Attributes:
        findings: What was found so far.
    """

    def __init__(self, log: Log) -> None:
        self.findings: list[Finding] = []
        self._log = log

    def add(self, severity: Severity, subject: Subject, code: str, message: str) -> None:
        """Note a finding."""
        self.findings.append(Finding(severity, code, message, subject))

    def warn(self, subject: Subject, code: str, message: str) -> None:
        """Note something doubtful."""
        self.add("warning", subject, code, message)

    def trace(self, doing: str) -> None:
        """Log the exception that is being handled."""
        self._log(f"CARDSFlow: {doing}\n{traceback.format_exc()}")

    def attempt(
        self,
        subject: Subject,
        what: str,
        work: Callable[..., Result],
        *arguments: Any,
        severity: Severity = "error",
        todo: str = REPAIR,
    ) -> Result | None:
        """Do work that may fail; a failure becomes a finding.

        Args:
            subject: The object that is read.
            what: What of it is read, such as `mass`.
            work: Reads it.
            arguments: Of the work.
            severity: How bad it is if it cannot be read.
            todo: What the user can do then.

        Returns:
            What the work gives; None if it failed.
        """
        try:
            return work(*arguments)
        except Cancelled:
            raise
        except Exception as error:
            self.trace(f"{subject.kind} {subject.name}: {what}")
            problem = f"its {what} cannot be read ({error}). {todo}"
            self.add(severity, subject, "not-read", f"{subject.kind} {subject.name!r}: {problem}")
            return None

    def sorted(self) -> tuple[Finding, ...]:
        """The findings, each once, in an order that does not depend on the design's making."""
        unique = dict.fromkeys(self.findings)
        return tuple(sorted(unique, key=lambda f: (f.subject, f.code, f.message)))


def optional(read: Callable[[], Result]) -> Result | None:
    """Return a value that Fusion may not have; None if reading it fails, as in older versions.

    Args:
        read: Reads it. What must be there is read by `Notes.attempt`.
    """
    try:
        return read()
    except Cancelled:
        raise
    except Exception:
        return None


def items(
    collection: Callable[[], Any], notes: Notes, subject: Subject, what: str
) -> Iterator[Any]:
    """The items of a collection of the API; one that cannot be had does not hide the others.

    Args:
        collection: Gives it; called once.
        notes: Takes what fails.
        subject: What the collection belongs to.
        what: What it holds, such as `joints`.
    """
    held = notes.attempt(subject, what, collection)
    if held is None:
        return
    try:
        found = list(held)
    except Cancelled:
        raise
    except Exception:  # one of them fails: read them one by one
        count = notes.attempt(subject, what, lambda: int(held.count)) or 0
        tried = (notes.attempt(subject, what, held.item, i) for i in range(count))
        found = [item for item in tried if item is not None]
    yield from found
