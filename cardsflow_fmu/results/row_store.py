"""Memory for the rows of a run: RAM, or a memory-mapped file for large tables."""

from __future__ import annotations

import contextlib
import errno
import mmap
import os
import tempfile
from contextlib import nullcontext
from pathlib import Path
from typing import BinaryIO

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import file_error
from cardsflow_fmu.utils.arrays import FloatArray

IN_MEMORY = 2**25
"""Maximum size of a table in memory, in bytes."""

_RELEASE_SIZE = 2**22
_NPY_TEXT = 118
_NPY_START = b"\x93NUMPY\x01\x00" + _NPY_TEXT.to_bytes(2, "little")


def is_large(count: int, columns: int) -> bool:
    """Return whether a table is too large for memory, and for CSV by default."""
    return 8 * count * columns > IN_MEMORY


class RowStore:
    """Table that is filled row by row.

    A large table is a memory-mapped file without a name in the results folder. The file is deleted
    when the process ends.

    Args:
        file: Empty file for the table in NumPy's format .npy, open for reading and writing
            (default: none). It is complete at any time, with the rows of the last `publish`.

    Attributes:
        rows: The table, shape (count, columns).
    """

    def __init__(
        self, count: int, columns: int, folder: Path, file: BinaryIO | None = None
    ) -> None:
        size = 8 * count * columns
        self._width, self._released = 8 * columns, 0
        self._memory: mmap.mmap | None = None
        self._head = 0 if file is None else len(_npy_header(count, columns))
        if file is None and not is_large(count, columns):
            self.rows: FloatArray = np.empty((count, columns))
            return
        try:
            with tempfile.TemporaryFile(dir=folder) if file is None else nullcontext(file) as table:
                _reserve(table.fileno(), self._head + size)
                self._memory = mmap.mmap(table.fileno(), self._head + size)
        except OSError as error:
            problem = f"has not enough space for a run of {count} rows, {size >> 20} MiB"
            raise file_error(error, problem, folder) from None
        self.rows = np.frombuffer(self._memory, offset=self._head).reshape(count, columns)
        if file is not None:
            self.publish(0)

    def publish(self, filled: int) -> None:
        """Set the number of rows in the header of the file."""
        assert self._memory is not None
        self._memory[: self._head] = _npy_header(filled, self.rows.shape[1])

    def finish(self, filled: int, file: Path) -> None:
        """Set the number of rows, end the file there, and protect it from changes."""
        self.publish(filled)
        self.rows.flags.writeable = False
        os.truncate(file, self._head + filled * self._width)

    def release(self, filled: int) -> None:
        """Release the memory of filled rows; the system reads them from the file when needed."""
        end = (self._head + filled * self._width) // _RELEASE_SIZE * _RELEASE_SIZE
        if self._memory is None or end <= self._released or not hasattr(mmap, "MADV_DONTNEED"):
            return
        # from the start: later reads may have mapped released pages again
        self._memory.madvise(mmap.MADV_DONTNEED, 0, end)
        self._released = end


def _npy_header(count: int, columns: int) -> bytes:
    """Return the header of a .npy file, which has the same length for every number of rows."""
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({count}, {columns}), }}"
    return _NPY_START + text.ljust(_NPY_TEXT - 1).encode("ascii") + b"\n"


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


def read_npy(file: Path, columns: int) -> FloatArray:
    """Map a table in NumPy's format .npy into memory, without reading it, shape (rows, columns)."""
    try:
        rows = np.lib.format.open_memmap(file, mode="r")
    except (OSError, ValueError, SyntaxError, EOFError, MemoryError, OverflowError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"is not an array of numbers: {reason}", file=file) from None
    if rows.dtype != np.float64 or rows.ndim != 2 or rows.shape[1] != columns:
        problem = f"is not an array of float64 with {columns} columns"
        raise InputError(f"{problem}, but {rows.dtype} of shape {rows.shape}", file=file)
    mapped: FloatArray = np.asarray(rows)
    return mapped
