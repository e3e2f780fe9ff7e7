"""Tables of numbers as CSV: exact floats, and a reader for untrusted files."""

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

_LONG = 120


def csv_text(names: Sequence[str], rows: FloatArray) -> str:
    """Return a table as CSV, with floats that can be read back exactly."""
    table = [rows_bytes(rows).decode("ascii")] if len(rows) else []
    return "\n".join([",".join(names), *table, ""])


def rows_bytes(rows: FloatArray) -> bytes:
    """Return rows as CSV without a final newline; numbers can be NaN or Infinity."""
    return to_json(rows.tolist())[2:-2].replace(b"],[", b"\n")


def read_csv(
    file: Path,
    *,
    complete: bool = True,
    kind: str = "table of results",
    most: int = limits.VALUES,
    blanks: bool = False,
) -> tuple[tuple[str, ...], FloatArray]:
    """Read a table and return its column names and its rows, shape (rows, len(names)).

    The separator of the first line (comma, semicolon or tab) is used for all lines.

    Args:
        kind: Expected kind of table, for messages.
        complete: Whether the file is complete. If not, a last line without newline is ignored.
        most: Maximum number of values.
        blanks: Whether fields can be empty; empty fields become NaN.

    Raises:
        InputError: The file is not a table of numbers.
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
                converter = _number_or_nan if blanks else None
                rows = np.loadtxt(lines, delimiter=delimiter, ndmin=2, converters=converter)
    except ValueError as error:
        raise InputError(format_error(error, kind), file=file) from None
    if not rows.size:
        rows = rows.reshape(0, len(names))
    if rows.shape[1] != len(names):
        fault = f"the first line has {len(names)} names, but the rows have {rows.shape[1]} numbers"
        raise InputError(f"is not a {kind}: {fault}", file=file)
    require_table(names, rows, file, kind=kind)
    return names, rows


def _number_or_nan(text: str) -> float:
    return float(text) if text.strip() else np.nan


def require_bounded(stream: BinaryIO, file: Path, most: int, between: bytes = b",;\t\n\r") -> None:
    """Reject a table that requires too much memory, and rewind the stream.

    Args:
        stream: The open file.
        file: Name of the file, for messages.
        most: Maximum number of values.
        between: Separators between numbers.

    Raises:
        InputError: The table has too many numbers, or a line is too long.
    """
    values = length = 0
    while block := stream.read(limits.MIB):
        values += sum(map(block.count, between))
        first, newline, _ = block.partition(b"\n")
        length += len(first)
        if length > limits.LINE:
            raise InputError(f"contains a line with more than {limits.LINE} bytes", file=file)
        if newline:
            length = len(block) - block.rindex(b"\n") - 1
    if values > most:
        raise InputError(f"contains more than {most} numbers", file=file)
    stream.seek(0)


def format_error(error: Exception, expected: str) -> str:
    """Return a one-line message that a file does not have the expected format."""
    if isinstance(error, UnicodeDecodeError):
        return f"is not a {expected}: it is not UTF-8 text"
    problem = str(error).partition(";")[0].replace("\0", "\\0")  # without NumPy's hints
    return f"is not a {expected}: {problem if len(problem) < _LONG else problem[:_LONG] + '...'}"


def require_table(
    names: Sequence[str], rows: FloatArray, file: Path | None, *, kind: str = "table of results"
) -> None:
    """Reject missing or duplicate column names, and times that are not finite or decrease.

    Args:
        rows: Values, shape (rows, len(names)).
        file: File of the table, for messages.
        kind: Expected kind of table, for messages.
    """
    problem = _fault(names, rows)
    if problem is not None:
        raise InputError(f"is not a {kind}: {problem}" if any(names) else problem, file=file)


def _fault(names: Sequence[str], rows: FloatArray) -> str | None:
    """Return the error in a table, or None."""
    if len(names) > limits.COLUMNS:
        return f"it has more than {limits.COLUMNS} columns"
    if len(rows) > limits.ROWS:
        return f"it has more than {limits.ROWS} rows"
    if not any(names):
        return "is empty: a line with the names of the columns is required"
    if not all(names):
        return f"column {names.index('') + 1} has no name"
    if len(set(names)) < len(names):
        twice = next(name for name, count in Counter(names).items() if count > 1)
        return f"it has two columns {twice[:_LONG]!r}"
    if "time" not in names:
        return None
    time = rows[:, list(names).index("time")]
    if not np.isfinite(time).all():
        k = int(np.flatnonzero(~np.isfinite(time))[0])
        return f"the time of row {k + 1} is {time[k]}"
    if (np.diff(time) < 0.0).any():
        k = int(np.flatnonzero(np.diff(time) < 0.0)[0])
        return f"the time decreases after row {k + 1}, from {time[k]:g} s"
    return None
