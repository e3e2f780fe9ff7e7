"""Tables of numbers as CSV: exact floats, and reading of possibly damaged files."""

from __future__ import annotations

import io
import warnings
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np
from pydantic_core import to_json

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import open_file
from cardsflow_fmu.utils.arrays import FloatArray

_BLOCK = 4096
_LONG = 120


def csv_text(names: Sequence[str], rows: FloatArray) -> str:
    """Return a table as CSV, every float such that it reads back exactly.

    Args:
        names: Name of every column.
        rows: Values, shape (rows, len(names)).
    """
    blocks = [",".join(names)]
    for first in range(0, len(rows), _BLOCK):  # as Python floats, all would be large
        blocks.append(rows_text(rows[first : first + _BLOCK]))
    return "\n".join(blocks) + "\n"


def rows_text(rows: FloatArray) -> str:
    """Return rows as CSV without the last line end; numbers may be NaN or Infinity.

    Args:
        rows: Values, shape (rows, columns).
    """
    # a fifth of the time of `repr`
    return to_json(rows.tolist()).decode()[2:-2].replace("],[", "\n")


def read_csv(
    file: Path,
    *,
    complete: bool = True,
    what: str = "table of results",
    most: int = limits.VALUES,
    blanks: bool = False,
) -> tuple[tuple[str, ...], FloatArray]:
    """Return the names and the rows of a table, shape (rows, len(names)).

    Between columns are commas, semicolons or tabs, as between their names.

    Args:
        file: The table.
        what: What it should be, for messages.
        complete: Whether the last line has been written whole; otherwise it counts only if it ends.
        most: So many numbers are taken; more are rejected.
        blanks: Whether fields may be empty, and are then NaN.

    Raises:
        InputError: It is not a table of numbers.
    """
    try:
        with open_file(file, limits.TABLE) as binary:
            require_bounded(binary, file, most)
            stream = io.TextIOWrapper(binary, encoding="utf-8-sig")
            header = stream.readline().rstrip("\n")
            delimiter = next((sign for sign in ",;\t" if sign in header), ",")
            names = tuple(name.strip().strip('"') for name in header.split(delimiter))
            lines = stream if complete else (line for line in stream if line.endswith("\n"))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # about a table without rows
                read = _or_blank if blanks else None
                rows = np.loadtxt(lines, delimiter=delimiter, ndmin=2, converters=read)
    except ValueError as error:
        raise InputError(reason(error, what), file=file) from None
    if not rows.size:
        rows = rows.reshape(0, len(names))
    if rows.shape[1] != len(names):
        found = f"{len(names)} columns have names, and rows have {rows.shape[1]} numbers"
        raise InputError(f"is not a {what}: {found}", file=file)
    require_table(names, rows, file, what=what)
    return names, rows


def _or_blank(text: str) -> float:
    return float(text) if text.strip() else np.nan


def require_bounded(stream: BinaryIO, file: Path, most: int, between: bytes = b",;\t\n\r") -> None:
    """Reject a table that would take too much memory, and go back to its beginning.

    Args:
        stream: The file, opened.
        file: Its name.
        most: So many numbers are taken.
        between: What may stand between two numbers.

    Raises:
        InputError: It has too many numbers or columns, or a line that is too long.
    """
    values = length = 0
    while block := stream.read(limits.MIB):
        values += sum(map(block.count, between))
        first, newline, _ = block.partition(b"\n")
        length += len(first)
        if length > limits.LINE:
            raise InputError(f"holds a line of more than {limits.LINE} bytes", file=file)
        if newline:
            length = len(block) - block.rindex(b"\n") - 1
    if values > most:
        raise InputError(f"holds more than {most} numbers", file=file)
    stream.seek(0)


def reason(error: Exception, expected: str) -> str:
    """Why a file is not what is expected, in a line."""
    if isinstance(error, UnicodeDecodeError):
        return f"is not a {expected}: it is not UTF-8 text"
    what = str(error).partition(";")[0].replace("\0", "\\0")  # what follows is for programmers
    return f"is not a {expected}: {what if len(what) < _LONG else what[:_LONG] + '...'}"


def require_table(
    names: Sequence[str], rows: FloatArray, file: Path | None, *, what: str = "table of results"
) -> None:
    """Reject columns of one name or of none, and times that are not numbers that rise.

    Args:
        names: Of the columns.
        rows: Shape (rows, len(names)).
        file: Where it comes from.
        what: What it should be, for messages.

    Raises:
        InputError: It is none.
    """
    found = _fault(names, rows)
    if found is not None:
        raise InputError(f"is not a {what}: {found}" if any(names) else found, file=file)


def _fault(names: Sequence[str], rows: FloatArray) -> str | None:
    """What is wrong with a table; None for nothing."""
    if len(names) > limits.COLUMNS:
        return f"there are more than {limits.COLUMNS} columns"
    if not any(names):
        return "is empty: there is no line with the names of columns"
    if not all(names):
        return f"column {names.index('') + 1} has no name"
    if len(set(names)) < len(names):
        twice = next(name for name, count in Counter(names).items() if count > 1)
        return f"there are two columns {twice[:_LONG]!r}"
    if "time" not in names:
        return None
    time = rows[:, list(names).index("time")]
    if not np.isfinite(time).all():
        k = int(np.flatnonzero(~np.isfinite(time))[0])
        return f"the time of row {k + 1} is {time[k]}"
    if (np.diff(time) < 0.0).any():
        k = int(np.flatnonzero(np.diff(time) < 0.0)[0])
        return f"the time goes back after row {k + 1}, from {time[k]:g} s"
    return None
