"""The folder that a run writes into: usable before the run, and nobody else's files touched."""

from __future__ import annotations

import contextlib
import json
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Self

from addin_sdfusion.robot import InputError

_RESULTS = ("results.csv", "results.units.json", "summary.json", "tracking.png", "tracking.svg")
_FMUS = ("plant.fmu", "controller.fmu", "reference.fmu")


class OutputFolder:
    """A context that makes the folder and removes what it made if `keep` is not reached.

    Args:
        path: The folder.

    Raises:
        InputError: On entering: the folder cannot be written, or holds files of these names that
            no run has written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._made: list[Path] = []
        self._before: set[str] = set()
        self._kept = False

    def keep(self) -> None:
        """From here on, what is in the folder stays."""
        self._kept = True

    def __enter__(self) -> Self:
        try:
            self._refuse_foreign_files()
            self._make()
            self._before = {name for name in _RESULTS + _FMUS if (self.path / name).exists()}
            with tempfile.TemporaryFile(dir=self.path):
                pass
        except (OSError, ValueError) as error:
            with contextlib.suppress(OSError, ValueError):
                self._undo()
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError(
                f"the output folder cannot be written: {reason}", file=self.path
            ) from None
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if not self._kept:
            self._undo()

    def _refuse_foreign_files(self) -> None:
        """Results of an earlier run are replaced; files of the same names by others are not."""
        there = [name for name in _RESULTS if (self.path / name).exists()]
        if there and not _is_summary(self.path / "summary.json"):
            what = f"holds {there[0]}, which no run has written; choose another output folder"
            raise InputError(what, file=self.path)

    def _make(self) -> None:
        missing = [p for p in (self.path, *self.path.parents) if not p.exists()]
        for folder in reversed(missing):
            folder.mkdir()
            self._made.append(folder)

    def _undo(self) -> None:
        """Remove the files and folders that this run has added."""
        for name in set(_RESULTS + _FMUS) - self._before:
            (self.path / name).unlink(missing_ok=True)
        for folder in reversed(self._made):
            folder.rmdir()


def _is_summary(file: Path) -> bool:
    """Whether a run has written this file."""
    try:
        return "cardsflow" in json.loads(file.read_text(encoding="utf-8"))["versions"]
    except (OSError, ValueError, TypeError, KeyError):
        return False
