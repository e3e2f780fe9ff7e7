"""Exceptions of CARDSFlow. Messages state the location, the error and the known names."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path

from .finding import Finding, truncate

_MAX_COMPARED, _MAX_KEY, _MAX_PATH = 1000, 200, 1000


class CardsflowError(Exception):
    """Base class of all errors that CARDSFlow raises."""


class InputError(CardsflowError):
    """An error in the user's input: a file, a key or a value.

    Args:
        problem: Description of the error and how to correct it, without the location.
        file: File with the error.
        line: Line in that file, counted from 1.
        key: Key with the error, such as `controller.period`.

    Attributes:
        more: Further errors in the same file.
    """

    def __init__(
        self,
        problem: str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        key: str | None = None,
    ) -> None:
        self.problem = problem
        self.file = None if file is None else Path(file)
        self.line = line
        self.key = key
        self.more: tuple[InputError, ...] = ()
        super().__init__(problem)

    def __str__(self) -> str:
        """Return the message with its location; further errors are on separate lines."""
        place = "" if self.file is None else truncate(str(self.file), _MAX_PATH)
        if place and self.line is not None:
            place += f":{self.line}"
        parts = [
            part
            for part in (place, truncate(self.key or "", _MAX_KEY), truncate(self.problem))
            if part
        ]
        return "\n".join([": ".join(parts), *map(str, self.more)])


class UnknownNameError(InputError):
    """An unknown name. The message suggests the most similar known name.

    Args:
        kind: Kind of object, such as `muscle`.
        name: The unknown name.
        file: File with the error.
        line: Line in that file, counted from 1.
        key: Key with the error.
    """

    def __init__(
        self,
        kind: str,
        name: str,
        known: Iterable[str],
        *,
        file: str | Path | None = None,
        line: int | None = None,
        key: str | None = None,
    ) -> None:
        self.kind = kind
        self.name = name
        self.known = tuple(known)
        compared = self.known[:_MAX_COMPARED]
        nearest = difflib.get_close_matches(name[:_MAX_KEY], compared, n=1, cutoff=0.5)
        hint = f"; did you mean {nearest[0]!r}?" if nearest else ""
        listed = ", ".join(self.known[:20]) + (", ..." if len(self.known) > 20 else "")
        problem = f"no {kind} {name!r}{hint} (known: {listed or 'none'})"
        super().__init__(problem, file=file, line=line, key=key)


class RobotError(InputError):
    """Errors in a robot or in its files.

    Args:
        findings: All findings, with at least one error.
        file: The file of the robot, if known.
        format_: The format that does not support the robot, or None if the robot is invalid.
    """

    def __init__(
        self,
        findings: Iterable[Finding],
        *,
        file: str | Path | None = None,
        format_: str | None = None,
    ) -> None:
        self.findings = tuple(findings)
        errors = [finding for finding in self.findings if finding.is_error]
        first = errors[0]
        problem = first.message
        if len(errors) > 1:
            check = "cardsflow check" if format_ is None else f"cardsflow check --for {format_}"
            problem += f" (and {len(errors) - 1} more; `{check}` lists all)"
        super().__init__(problem, file=first.file or file, line=first.line)


class MachineError(CardsflowError):
    """An error of the operating system, such as a full disk or too many open files."""

    def __init__(self, problem: str, file: str | Path) -> None:
        self.problem, self.file = problem, Path(file)
        super().__init__(f"{truncate(str(file), _MAX_PATH)}: {problem}")


class SimulationError(CardsflowError):
    """A run that cannot continue: the state is not finite, or an FMU reports an error."""
