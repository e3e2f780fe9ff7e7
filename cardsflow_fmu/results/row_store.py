"""Memory for the rows of a run: RAM, or a memory-mapped file for large tables."""

from __future__ import annotations

import contextlib
import errno
import mmap
import os
import tempfile
from pathlib import Path

import numpy as np

from addin_sdfusion.robot.files import file_error
from cardsflow_fmu.utils.arrays import FloatArray

IN_MEMORY = 2**25
"""Maximum size of a table in memory, in bytes."""

_RELEASE_SIZE = 2**22


class RowStore:
    """Table that is filled row by row.

    A large table is a memory-mapped file without a name in the results folder. The file is deleted
    when the process ends.

    Args:
        count: Number of rows.
        columns: Number of columns.
        folder: Folder of the file.

    Attributes:
        rows: The table, shape (count, columns).

    Raises:
        InputError: The file cannot be created in the folder.
        MachineError: The disk is full.
    """

    def __init__(self, count: int, columns: int, folder: Path) -> None:
        size = 8 * count * columns
        self._width, self._released = 8 * columns, 0
        self._memory: mmap.mmap | None = None
        if size <= IN_MEMORY:
            self.rows: FloatArray = np.empty((count, columns))
            return
        try:
            with tempfile.TemporaryFile(dir=folder) as file:
                _reserve(file.fileno(), size)
                self._memory = mmap.mmap(file.fileno(), size)
        except OSError as error:
            what = f"has not enough space for a run of {count} rows, {size >> 20} MiB"
            raise file_error(error, what, folder) from None
        self.rows = np.frombuffer(self._memory).reshape(count, columns)

    def release(self, filled: int) -> None:
        """Release the memory of filled rows; the system reads them from the file when needed."""
        end = filled * self._width // _RELEASE_SIZE * _RELEASE_SIZE
        if self._memory is None or end <= self._released or not hasattr(mmap, "MADV_DONTNEED"):
            return
        # from the start: later reads may have mapped released pages again
        self._memory.madvise(mmap.MADV_DONTNEED, 0, end)
        self._released = end


def _reserve(descriptor: int, size: int) -> None:
    """Allocate the space of a file. Without this, a full disk would end the process later."""
    with contextlib.suppress(AttributeError):  # not available on all systems
        try:
            os.posix_fallocate(descriptor, 0, size)
            return
        except OSError as error:
            if error.errno not in (errno.EOPNOTSUPP, errno.EINVAL):
                raise
    os.truncate(descriptor, size)
