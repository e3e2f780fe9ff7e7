"""Errors of CARDSFlow: one root, and messages with the fault, its place and the known names."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path

from .finding import Finding, cut

_MAX_COMPARED, _MAX_KEY, _MAX_PATH = 1000, 200, 1000


class CardsflowError(Exception):
    """The root of every error that CARDSFlow raises on purpose."""


class InputError(CardsflowError):
    """Something the user gave is wrong: a file, a key, a value.

    Args:
        what: What is wrong and what to do, without the place.
        file: The file concerned.
        line: The line in that file, counted from 1.
        key: The key concerned, such as `controller.period`.

    Attributes:
        more: What else is wrong with the same file.
    """

    def __init__(
        self,
        what: str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        key: str | None = None,
    ) -> None:
        self.what = what
        self.file = None if file is None else Path(file)
        self.line = line
        self.key = key
        self.more: tuple[InputError, ...] = ()
        super().__init__(what)

    def __str__(self) -> str:
        """The message, led by the place; a line for each thing that is wrong."""
        place = "" if self.file is None else cut(str(self.file), _MAX_PATH)
        if place and self.line is not None:
            place += f":{self.line}"
        parts = [part for part in (place, cut(self.key or "", _MAX_KEY), cut(self.what)) if part]
        return "\n".join([": ".join(parts), *map(str, self.more)])


class UnknownNameError(InputError):
    """A name that does not exist, with the nearest one that does.

    Args:
        kind: What the name should have named, such as `muscle`.
        name: The name that was given.
        known: The names that exist.
        file: The file concerned.
        line: The line in that file, counted from 1.
        key: The key concerned.
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
        what = f"no {kind} {name!r}{hint} (known: {listed or 'none'})"
        super().__init__(what, file=file, line=line, key=key)


class RobotError(InputError):
    """A robot, or the files that describe it, cannot be used.

    Args:
        findings: Everything that is wrong; at least one finding is an error.
        file: The file that was read, if there is one.
        format_: The format that cannot hold the robot; None if the robot itself is wrong.
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
        what = first.message
        if len(errors) > 1:
            check = "cardsflow check" if format_ is None else f"cardsflow check --for {format_}"
            what += f" (and {len(errors) - 1} more: `{check}` lists all)"
        super().__init__(what, file=first.file or file, line=first.line)


class MachineError(CardsflowError):
    """The machine fails, not what it was given: a full disk, a broken drive, too many open files.

    Args:
        what: What fails.
        file: The file or folder concerned.
    """

    def __init__(self, what: str, file: str | Path) -> None:
        self.what, self.file = what, Path(file)
        super().__init__(f"{cut(str(file), _MAX_PATH)}: {what}")


class SimulationError(CardsflowError):
    """A run cannot continue: the state is no longer finite, or an FMU reported an error."""
