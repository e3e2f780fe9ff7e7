"""Findings on parts of a design that cannot be read, with tracebacks for the log."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

from ..progress import Cancelled
from ..robot.finding import Finding, Severity, Subject

Log = Callable[[str], None]
Result = TypeVar("Result")

REPAIR = "Repair it in Fusion (Modify > Compute All shows what is broken) or delete it"
"""Default advice for objects that cannot be read."""


class Notes:
    """Collector of findings while a design is read."""

    def __init__(self, log: Log) -> None:
        self.findings: list[Finding] = []
        self._log = log

    def add(self, severity: Severity, subject: Subject, code: str, message: str) -> None:
        """Add a finding."""
        self.findings.append(Finding(severity, code, message, subject))

    def warn(self, subject: Subject, code: str, message: str) -> None:
        """Add a warning."""
        self.add("warning", subject, code, message)

    def trace(self, doing: str) -> None:
        """Log the traceback of the current exception."""
        self._log(f"CARDSFlow: {doing}\n{traceback.format_exc()}")

    def attempt(
        self,
        subject: Subject,
        label: str,
        work: Callable[..., Result],
        *arguments: Any,
        severity: Severity = "error",
        todo: str = REPAIR,
    ) -> Result | None:
        """Call a function that may fail; an exception becomes a finding.

        Args:
            subject: The object that is read.
            label: Name of the property that is read, such as `mass`.
            work: Function that reads the property.
            todo: Advice to the user.

        Returns:
            Result of the function; None if it failed.
        """
        try:
            return work(*arguments)
        except Cancelled:
            raise
        except Exception as error:
            self.trace(f"{subject.kind} {subject.name}: {label}")
            problem = f"its {label} cannot be read ({error}). {todo}"
            self.add(severity, subject, "not-read", f"{subject.kind} {subject.name!r}: {problem}")
            return None

    def sorted(self) -> tuple[Finding, ...]:
        """Return each finding once, in an order that does not depend on the reading order."""
        unique = dict.fromkeys(self.findings)
        return tuple(sorted(unique, key=lambda f: (f.subject, f.code, f.message)))


def optional(read: Callable[[], Result]) -> Result | None:
    """Return an optional value; None if reading it fails, as in older versions of Fusion.

    Args:
        read: Function that reads the value. Use `Notes.attempt` for required values.
    """
    try:
        return read()
    except Cancelled:
        raise
    except Exception:
        return None


def items(
    collection: Callable[[], Any], notes: Notes, subject: Subject, label: str
) -> Iterator[Any]:
    """Yield the items of a collection of the API; items that cannot be read are skipped.

    Args:
        collection: Function that returns the collection; called once.
        subject: Owner of the collection.
        label: Name of the items, such as `joints`.
    """
    collected = notes.attempt(subject, label, collection)
    if collected is None:
        return
    try:
        members = list(collected)
    except Cancelled:
        raise
    except Exception:  # an item fails: read the items one by one
        count = notes.attempt(subject, label, lambda: int(collected.count)) or 0
        tried = (notes.attempt(subject, label, collected.item, i) for i in range(count))
        members = [item for item in tried if item is not None]
    yield from members
