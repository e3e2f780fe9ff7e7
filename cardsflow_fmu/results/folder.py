"""Results folder of a run. It is checked before the run. Other files in it are not changed."""

from __future__ import annotations

import contextlib
import json
import tempfile
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Self

from addin_sdfusion.robot import CardsflowError, InputError, limits
from addin_sdfusion.robot.files import file_error, read_file, write_files
from cardsflow_fmu.utils.folder_lock import create_folder

from .estimation import UPDATED_CALIBRATION
from .files import RECORDING_FILE

_SUMMARY = "summary.json"
_RESULT_FILES = (
    "results.csv",
    "results.npy",
    "recording.mcap",
    "solve_times.csv",
    "solve_times.npy",
    "results.units.json",
    _SUMMARY,
    "tracking.png",
    "tracking.svg",
    "path.png",
    "path.svg",
    "world.png",
    "world.svg",
    "experiment.zip",
    "plant.fmu",
    "controller.fmu",
    "reference.fmu",
    "hardware.fmu",
    RECORDING_FILE,
    UPDATED_CALIBRATION,
)


class OutputFolder:
    """Context that creates and locks a results folder; a new folder without results is removed.

    Raises:
        InputError: On entering: the folder cannot be written, another program uses it, or it has
            files with names of results that no run has written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._stack = contextlib.ExitStack()

    def write(
        self, contents: Mapping[str, str | bytes], streamed: Collection[str] = ()
    ) -> dict[str, Path]:
        """Replace the results of an earlier run: all files, or none on an error.

        Args:
            contents: Content of each file, by name.
            streamed: Names of files that the run has already written.

        Raises:
            InputError: A file cannot be written.
        """
        written = write_files(self.path, contents)
        for name in set(_RESULT_FILES) - set(contents) - set(streamed):
            (self.path / name).unlink(missing_ok=True)
        return {path.name: path for path in [*written, *(self.path / n for n in streamed)]}

    def __enter__(self) -> Self:
        try:
            self._stack.enter_context(create_folder(self.path, "run"))
            self._check_existing_files()
            with tempfile.TemporaryFile(dir=self.path):
                pass
        except CardsflowError:
            self._stack.close()
            raise
        except (OSError, ValueError) as error:
            self._stack.close()
            raise file_error(error, "the output folder cannot be written", self.path) from None
        return self

    def __exit__(self, *exception: object) -> None:
        self._stack.close()

    def _check_existing_files(self) -> None:
        """Check that existing files with names of results are from an earlier run."""
        link = next((name for name in _RESULT_FILES if (self.path / name).is_symlink()), None)
        if link is not None:  # a link would redirect the write to another file
            problem = f"has a link {link}; remove it, or choose another output folder"
            raise InputError(problem, file=self.path)
        existing = [name for name in _RESULT_FILES if (self.path / name).exists()]
        if RECORDING_FILE in existing and _is_recording(self.path / RECORDING_FILE):
            existing.remove(RECORDING_FILE)  # from a run that was killed
        if existing and not _is_summary(self.path / _SUMMARY):
            problem = f"has a file {existing[0]} that no run has written"
            raise InputError(f"{problem}; choose another output folder", file=self.path)


def _is_recording(file: Path) -> bool:
    from cardsflow_fmu.hardware.protocol.recording import is_recording

    return is_recording(file)


def _is_summary(file: Path) -> bool:
    """Return whether a run has written this file; raise InputError if it cannot be read."""
    data = read_file(file, limits.JSON) if file.is_file() else b""
    try:
        return "cardsflow" in json.loads(data)["versions"]
    except (ValueError, TypeError, KeyError, RecursionError):
        return False
