"""Tables of OpenSim: .mot and .sto files of motions, states and forces."""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, TextIO

import numpy as np

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import open_file
from cardsflow_fmu.utils.arrays import FloatArray

from .csv_table import csv_text, reason, require_bounded, require_table

FILE_TYPES = (".mot", ".sto")

_WHAT = "table of OpenSim"
_MAX_HEADER = 1000  # lines
_STATE = re.compile(r"/jointset/[^/]+/(?P<coordinate>[^/]+)/(?P<kind>value|speed)")


class OpenSimTable(NamedTuple):
    """A table.

    Attributes:
        names: Of the columns.
        rows: Shape (rows, columns).
        in_degrees: Whether angles are in degrees.
    """

    names: tuple[str, ...]
    rows: FloatArray
    in_degrees: bool


def read_opensim_table(file: Path) -> OpenSimTable:
    """Return the table in a .mot or .sto file.

    Raises:
        InputError: It is none.
    """
    try:
        with open_file(file, limits.TABLE) as binary:
            require_bounded(binary, file, limits.MOTION_VALUES, b" ,;\t\n\r")
            stream = io.TextIOWrapper(binary, encoding="utf-8-sig")
            in_degrees, line = _header(stream, file)
            labels = stream.readline().rstrip("\r\n")
            names = tuple(labels.strip().split("\t") if "\t" in labels else labels.split())
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # about a table without rows
                rows = np.loadtxt(stream, ndmin=2)
    except ValueError as error:
        raise InputError(reason(error, _WHAT), file=file) from None
    names = tuple(name.strip() for name in names)
    rows = rows if rows.size else rows.reshape(0, len(names))
    if rows.shape[1] != len(names):
        found = f"line {line + 1} names {len(names)} columns, and rows have {rows.shape[1]} numbers"
        raise InputError(f"is not a {_WHAT}: {found}", file=file)
    require_table(names, rows, file, what=_WHAT)
    return OpenSimTable(names, rows, in_degrees)


def _header(stream: TextIO, file: Path) -> tuple[bool, int]:
    """Return whether it says that angles are in degrees, and the number of its last line."""
    in_degrees = False
    for number in range(1, _MAX_HEADER + 1):
        line = stream.readline()
        word = line.strip().lower()
        if word == "endheader":
            return in_degrees, number
        if not line:
            break
        key, _, value = word.partition("=")
        if key.strip() == "indegrees":
            if value.strip() not in ("yes", "no"):
                raise InputError(f"inDegrees is yes or no, not {value.strip()!r}", file=file)
            in_degrees = value.strip() == "yes"
    raise InputError(
        f"is not a {_WHAT}: there is no line `endheader` before its columns", file=file
    )


def joint_columns(table: OpenSimTable, lengths: Sequence[str] = ()) -> dict[str, FloatArray]:
    """Return columns as those of a recorded motion: `time`, `q.<coordinate>` and `qd.<coordinate>`.

    Args:
        table: Positions by the coordinates' names, or states by their paths in the model.
        lengths: Coordinates that are lengths, in [m] in tables in degrees as well.
    """
    found = {}
    for name, column in zip(table.names, table.rows.T, strict=True):
        state = _STATE.fullmatch(name)
        own = name if state is None else state["coordinate"]
        letter = "qd" if state is not None and state["kind"] == "speed" else "q"
        is_angle = own != "time" and own not in lengths
        factor = np.pi / 180.0 if table.in_degrees and is_angle else 1.0
        found[own if own == "time" else f"{letter}.{own}"] = column * factor
    return found


def opensim_text(title: str, names: Sequence[str], rows: FloatArray) -> str:
    """Return a table as OpenSim's .sto, in SI units, every float such that it reads back exactly.

    Args:
        title: What it holds.
        names: Of the columns, `time` first.
        rows: Shape (rows, columns).
    """
    header = [title, "version=1", f"nRows={len(rows)}", f"nColumns={len(names)}", "inDegrees=no"]
    table = csv_text(names, rows).replace(",", "\t")
    return "\n".join([*header, "endheader", table])
