"""Result tables as CSV: exact floats, and reading of possibly damaged files."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.arrays import FloatArray

_BLOCK = 4096
_LONG = 120


def csv_text(names: Sequence[str], rows: FloatArray) -> str:
    """A table as CSV, every float such that it reads back exactly.

    Args:
        names: Name of every column.
        rows: Values, shape (rows, len(names)).
    """
    blocks = [",".join(names)]
    for first in range(0, len(rows), _BLOCK):  # as Python floats, all would be large
        blocks.append("\n".join(map(row_text, rows[first : first + _BLOCK])))
    return "\n".join(blocks) + "\n"


def row_text(row: FloatArray) -> str:
    """A row as CSV, without the end of the line.

    Args:
        row: Values, shape (columns,).
    """
    return ",".join(map(repr, row.tolist()))


def read_csv(file: Path, *, complete: bool = True) -> tuple[tuple[str, ...], FloatArray]:
    """The names and the rows of a table, shape (rows, len(names)).

    Args:
        file: The table.
        complete: Whether the last line has been written whole; otherwise it counts only if it ends.

    Raises:
        InputError: It is no table of numbers.
    """
    try:
        with file.open(encoding="utf-8-sig") as stream:
            names = tuple(name.strip() for name in stream.readline().rstrip("\n").split(","))
            lines = stream if complete else (line for line in stream if line.endswith("\n"))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # about a table without rows
                rows = np.loadtxt(lines, delimiter=",", ndmin=2).reshape(-1, len(names))
    except (OSError, ValueError) as error:
        raise InputError(_reason(error), file=file) from None
    require_table(names, rows, file)
    return names, rows


def _reason(error: Exception) -> str:
    if isinstance(error, OSError):
        return f"cannot be read: {error.strerror}"
    if isinstance(error, UnicodeDecodeError):
        return "is no table of results: it is not UTF-8 text"
    what = str(error).partition(";")[0].replace("\0", "\\0")  # what follows is for programmers
    return f"is no table of results: {what if len(what) < _LONG else what[:_LONG] + '...'}"


def require_table(names: Sequence[str], rows: FloatArray, file: Path) -> None:
    """Refuse columns of one name or of none, and times that are not numbers that rise.

    Args:
        names: Of the columns.
        rows: Shape (rows, len(names)).
        file: Where it comes from.

    Raises:
        InputError: It is no table of results.
    """
    if not any(names):
        raise InputError("is empty: there is no line with the names of columns", file=file)
    if not all(names):
        what = f"is no table of results: column {names.index('') + 1} has no name"
        raise InputError(what, file=file)
    if len(set(names)) < len(names):
        twice = next(name for k, name in enumerate(names) if name in names[:k])
        what = f"is no table of results: there are two columns {twice[:_LONG]!r}"
        raise InputError(what, file=file)
    if "time" not in names:
        return
    time = rows[:, list(names).index("time")]
    if not np.isfinite(time).all():
        k = int(np.flatnonzero(~np.isfinite(time))[0])
        raise InputError(f"is no table of results: the time of row {k + 1} is {time[k]}", file=file)
    if (np.diff(time) < 0.0).any():
        k = int(np.flatnonzero(np.diff(time) < 0.0)[0])
        what = f"is no table of results: the time goes back after row {k + 1}, from {time[k]:g} s"
        raise InputError(what, file=file)
