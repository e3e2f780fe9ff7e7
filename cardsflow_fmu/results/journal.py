"""Journal of a run: the results table is written during the run and is readable at any time."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping
from io import FileIO
from typing import Any, Literal, Self

from addin_sdfusion.robot import SimulationError
from addin_sdfusion.robot.files import replace_file
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.csv_table import rows_bytes

from .files import NPY, SUMMARY, TABLE, UNITS
from .folder import OutputFolder
from .row_store import RowStore, is_large

STARTED = SimulationError("the run was killed, or is still in progress")
"""Error in the summary until the run ends."""

_INTERVAL = 0.05
_BLOCK = 512
_MAX_VALUES = 2**16
"""Maximum number of values in a block with more than one row."""


class Journal:
    """Table of a run that is written row by row.

    Each row of a CSV table is formatted when it is added, because a real-time step has no time to
    format many rows. The folder is not changed before `begin`.

    Args:
        contents: Other files that exist before the first step, by name.
        streamed: Names of files that participants write into the folder.
        form: Format of the table: CSV, an array in NumPy's format .npy, or .npy if the table is
            large.
    """

    def __init__(
        self,
        folder: OutputFolder,
        contents: Mapping[str, str | bytes],
        streamed: Collection[str] = (),
        form: Literal["csv", "npy", "auto"] = "csv",
    ) -> None:
        self._folder, self._contents, self._streamed = folder, contents, streamed
        self._text = bytearray()  # formatted rows that are not yet written
        self._block = 0
        self._formatted = self._written = self._size = 0
        self._written_at = time.monotonic()
        self._file: FileIO | None = None
        self._store: RowStore | None = None
        self._form, self.table, self._is_closed = form, TABLE, False

    def begin(
        self, names: tuple[str, ...], units: Mapping[str, str], count: int, summary: dict[str, Any]
    ) -> None:
        """Replace the results of an earlier run by results without rows."""
        columns = len(names)
        if self._form == "npy" or (self._form == "auto" and is_large(count, columns)):
            self.table = NPY
        files = [SUMMARY, UNITS, self.table, *self._contents, *self._streamed]
        summary = summary | {"files": {name: name for name in files}}
        contents = {  # the summary first, because it marks the folder as results
            SUMMARY: json_text(summary, indent=1) + "\n",
            UNITS: json_text(dict(units), indent=1) + "\n",
            **self._contents,
        }
        folder, path = self._folder, self._folder.path / self.table
        if self.table == NPY:
            with replace_file(path) as file:  # the table last: it marks the results as complete
                self._store = RowStore(count, columns, folder.path, file)
                folder.write(contents, self._streamed)
            return
        self._store = RowStore(count, columns, folder.path)
        self._block = min(max(_MAX_VALUES // columns, 1), _BLOCK)
        header = ",".join(names) + "\n"
        folder.write(contents | {TABLE: header}, self._streamed)
        self._file = FileIO(path, "ab")
        self._size = len(header.encode())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    @property
    def rows(self) -> FloatArray:
        """Table to fill, shape (count, columns)."""
        assert self._store is not None
        return self._store.rows

    def update(self, filled: int) -> None:
        """Add new rows of the table; they are written within 0.05 s."""
        while self.table == TABLE and self._formatted < filled:
            begin, end = self._formatted, min(filled, self._written + self._block)
            self._text += rows_bytes(self.rows[begin:end]) + b"\n"
            self._formatted = end
            if end - self._written == self._block:
                self._flush()
                self._release()
        self._formatted = filled
        if filled - self._written < _BLOCK and time.monotonic() - self._written_at < _INTERVAL:
            return
        self._flush()
        self._release()

    def _release(self) -> None:
        """Release the memory of rows that are in a file."""
        assert self._store is not None
        self._store.release(self._formatted)

    def close(self) -> None:
        """Write all pending rows."""
        if self.table == NPY and self._store is not None and not self._is_closed:
            self._is_closed = True
            self._store.finish(self._formatted, self._folder.path / NPY)
        if self._file is None:
            return
        try:
            self._flush()
        finally:
            self._file.close()
            self._file = None

    def _flush(self) -> None:
        """Write all new rows: formatted rows as complete lines, or the number of rows."""
        if self.table == NPY and self._store is not None:
            self._store.publish(self._formatted)
            self._written, self._written_at = self._formatted, time.monotonic()
        if not self._text or self._file is None:
            return
        block, self._text = memoryview(self._text), bytearray()
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
            problem = f"the results cannot be written: {error.strerror}"
            raise SimulationError(problem) from None
