"""Storage of runs: one file per run, written atomically, with a checksum."""

from __future__ import annotations

import contextlib
import hashlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import CardsflowError, InputError, limits
from addin_sdfusion.robot.errors import MachineError
from addin_sdfusion.robot.files import file_error, read_file, remove_leftovers, write_files
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.studies.definition.errors import StudyError
from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.sampling import Run
from cardsflow_fmu.utils.folder_lock import lock_folder

RUNS = "runs"


class RunStore:
    """Storage of the runs of a study in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._runs = folder / RUNS

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """Create the folder and lock it against other programs, as a context.

        Raises:
            InputError: The folder cannot be written, or another program uses it.
        """
        try:
            self._runs.mkdir(parents=True, exist_ok=True)
        except (OSError, ValueError) as error:
            raise file_error(error, "cannot be written", self.folder) from None
        with lock_folder(self.folder, "study"):
            remove_leftovers(self.folder)
            remove_leftovers(self._runs)
            yield

    def hashes(self) -> set[str]:
        """Return the hashes of all stored runs."""
        return {file.stem for file in self._runs.glob("*.json")}

    def write(self, run: Run, outcome: Outcome) -> None:
        """Write the file of a run."""
        content = {
            "hash": run.hash,
            "settings": run.settings,
            "error": outcome.error,
            "metrics": outcome.metrics,
            "wall_time": outcome.wall_time,
            "overhead": outcome.overhead,
        }
        text = json_text(content | {"check": _check(content)}, indent=1) + "\n"
        try:
            write_files(self._runs, {f"{run.hash}.json": text})
        except CardsflowError as error:
            hint = "; free some disk space" if isinstance(error, MachineError) else ""
            raise StudyError(f"{error}{hint}") from None

    def read(self, run: Run) -> Outcome | None:
        """Return the outcome of a run, or None without a valid file."""
        content = self._content(self._runs / f"{run.hash}.json")
        if content is None or content["hash"] != run.hash:
            return None
        return Outcome(
            content["metrics"], content["error"], content["wall_time"], content["overhead"]
        )

    def settings(self, prefix: str) -> list[dict[str, Any]]:
        """Return the settings of all runs whose hash begins with a prefix."""
        contents = map(self._content, sorted(self._runs.glob(f"{prefix}*.json")))
        return [content["settings"] for content in contents if content is not None]

    def _content(self, file: Path) -> dict[str, Any] | None:
        try:
            content = json.loads(read_file(file, limits.JSON))
            check = content.pop("check")
            return content if check == _check(content) and _is_run(content) else None
        except (InputError, ValueError, KeyError, AttributeError, TypeError, RecursionError):
            return None


def _is_run(content: dict[str, Any]) -> bool:
    """Return whether the content has the types of `write`; a valid checksum is not sufficient."""
    texts = isinstance(content["hash"], str) and isinstance(content["error"], str | None)
    tables = isinstance(content["settings"], dict) and isinstance(content["metrics"], dict)
    numbers = (content["wall_time"], content["overhead"], *content["metrics"].values())
    return texts and tables and all(isinstance(value, int | float | None) for value in numbers)


def _check(content: dict[str, Any]) -> str:
    return hashlib.sha256(json_text(content, sort_keys=True).encode()).hexdigest()[:16]
