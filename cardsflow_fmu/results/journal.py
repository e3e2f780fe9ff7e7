"""Journal of a run: the results table is written during the run and is readable at any time."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping
from io import FileIO
from types import TracebackType
from typing import Any, Self

import numpy as np

from addin_sdfusion.robot import SimulationError
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.csv_table import rows_text

from .files import SUMMARY, TABLE, UNITS
from .folder import OutputFolder
from .row_store import RowStore

STARTED = SimulationError("the run was killed, or is still in progress")
"""Error in the summary until the run ends."""

_INTERVAL = 0.05
_BLOCK = 512


class Journal:
    """Table of a run that is written row by row.

    Each row is formatted when it is added, because a real-time step has no time to format many
    rows. The folder is not changed before `begin`.

    Args:
        folder: The results folder.
        contents: Other files that exist before the first step, by name.
        streamed: Names of files that participants write into the folder.
    """

    def __init__(
        self,
        folder: OutputFolder,
        contents: Mapping[str, str | bytes],
        streamed: Collection[str] = (),
    ) -> None:
        self._folder, self._contents, self._streamed = folder, contents, streamed
        self._blocks: list[str] = []
        self._formatted = self._written = self._size = 0
        self._written_at = time.monotonic()
        self._file: FileIO | None = None
        self._store: RowStore | None = None

    def begin(
        self, names: tuple[str, ...], units: Mapping[str, str], count: int, summary: dict[str, Any]
    ) -> None:
        """Replace the results of an earlier run by results without rows.

        Args:
            names: Names of the columns.
            units: Units of the columns.
            count: Maximum number of rows.
            summary: The summary before the first step, marked incomplete.

        Raises:
            MachineError: The disk is full.
            InputError: The folder cannot be written.
        """
        self._store = RowStore(count, len(names), self._folder.path)
        header = ",".join(names) + "\n"
        files = [SUMMARY, UNITS, TABLE, *self._contents, *self._streamed]
        summary = summary | {"files": {name: name for name in files}}
        self._folder.write(
            {  # the summary first, because it marks the folder as results
                SUMMARY: json_text(summary, indent=1) + "\n",
                UNITS: json_text(dict(units), indent=1) + "\n",
                **self._contents,
                TABLE: header,  # last: it marks the results as complete
            },
            self._streamed,
        )
        self._file = FileIO(self._folder.path / TABLE, "ab")
        self._size = len(header.encode())

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def rows(self) -> FloatArray:
        """Table to fill, shape (count, columns)."""
        assert self._store is not None
        return self._store.rows

    def update(self, filled: int) -> None:
        """Add new rows of the table; they are written within 0.05 s.

        Args:
            filled: Number of rows that are filled.

        Raises:
            SimulationError: The file cannot be written.
        """
        new = self.rows[self._formatted : filled]
        if len(new):
            self._blocks.append(rows_text(new))
        self._formatted = filled
        if filled - self._written < _BLOCK and time.monotonic() - self._written_at < _INTERVAL:
            return
        self._flush()
        assert self._store is not None
        self._store.release(filled)

    def close(self) -> None:
        """Write all pending rows."""
        if self._file is None:
            return
        try:
            self._flush()
        finally:
            self._file.close()
            self._file = None

    def _flush(self) -> None:
        """Write all formatted rows as complete lines."""
        if not self._blocks or self._file is None:
            return
        block = memoryview("\n".join([*self._blocks, ""]).encode())
        self._blocks.clear()
        self._written = self._formatted
        self._written_at = time.monotonic()
        try:
            done = 0
            while done < len(block):
                done += self._file.write(block[done:])
            self._size += done
        except OSError as error:
            self._file.truncate(self._size)
            self._file.close()
            self._file = None
            what = f"the results cannot be written: {error.strerror}"
            raise SimulationError(what) from None


def no_rows(names: tuple[str, ...]) -> FloatArray:
    """Return the empty table of a run before its first step."""
    return np.empty((0, len(names)))
