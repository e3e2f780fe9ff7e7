"""OpenSim tables: .mot and .sto files with motions, states and forces."""

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

from .csv_table import csv_text, format_error, require_bounded, require_table

FILE_TYPES = (".mot", ".sto")

_KIND = "valid OpenSim table"
_MAX_HEADER = 1000  # lines
_STATE = re.compile(r"/jointset/[^/]+/(?P<coordinate>[^/]+)/(?P<kind>value|speed)")


class OpenSimTable(NamedTuple):
    """An OpenSim table.

    Attributes:
        rows: Values, shape (rows, columns).
        in_degrees: Whether angles are in degrees.
    """

    names: tuple[str, ...]
    rows: FloatArray
    in_degrees: bool


def read_opensim_table(file: Path) -> OpenSimTable:
    """Read a .mot or .sto file."""
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
        raise InputError(format_error(error, _KIND), file=file) from None
    names = tuple(name.strip() for name in names)
    rows = rows if rows.size else rows.reshape(0, len(names))
    if rows.shape[1] != len(names):
        fault = f"line {line + 1} has {len(names)} names, but the rows have {rows.shape[1]} numbers"
        raise InputError(f"is not a {_KIND}: {fault}", file=file)
    require_table(names, rows, file, kind=_KIND)
    return OpenSimTable(names, rows, in_degrees)


def _header(stream: TextIO, file: Path) -> tuple[bool, int]:
    """Read the header; return whether angles are in degrees, and the number of its last line."""
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
                raise InputError(f"inDegrees must be yes or no, not {value.strip()!r}", file=file)
            in_degrees = value.strip() == "yes"
    raise InputError(
        f"is not a {_KIND}: the line `endheader` before the columns is missing", file=file
    )


def joint_columns(table: OpenSimTable, lengths: Sequence[str] = ()) -> dict[str, FloatArray]:
    """Return the columns of a recorded motion: `time`, `q.<coordinate>` and `qd.<coordinate>`.

    Args:
        table: Table of positions by coordinate name, or of states by their paths in the model.
        lengths: Names of coordinates in [m], which are not converted from degrees.
    """
    columns = {}
    for name, column in zip(table.names, table.rows.T, strict=True):
        state = _STATE.fullmatch(name)
        label = name if state is None else state["coordinate"]
        prefix = "qd" if state is not None and state["kind"] == "speed" else "q"
        is_angle = label != "time" and label not in lengths
        factor = np.pi / 180.0 if table.in_degrees and is_angle else 1.0
        columns[label if label == "time" else f"{prefix}.{label}"] = column * factor
    return columns


def opensim_text(title: str, names: Sequence[str], rows: FloatArray) -> str:
    """Return a table as OpenSim's .sto in SI units, with floats that can be read back exactly.

    Args:
        names: Names of the columns, `time` first.
        rows: Values, shape (rows, columns).
    """
    header = [title, "version=1", f"nRows={len(rows)}", f"nColumns={len(names)}", "inDegrees=no"]
    table = csv_text(names, rows).replace(",", "\t")
    return "\n".join([*header, "endheader", table])
