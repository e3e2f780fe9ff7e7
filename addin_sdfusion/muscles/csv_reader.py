"""Reader for muscle tables in CSV files, as written by `csv_writer`."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import get_args

from ..robot.errors import UnknownNameError
from ..robot.finding import Finding, Severity, Subject
from ..robot.model.muscle import CableKind
from ..robot.model.pose import Vector3
from ..robot.model.robot import POSITIONS, WORLD, Axis
from ..snapshot import COLOR, MuscleSnapshot, Role
from .rows import PointRow, by_name
from .table import MuscleTable

COLUMNS = (
    "role",
    "name",
    "number",
    "link",
    "x [m]",
    "y [m]",
    "z [m]",
    "color",
    "f_min [N]",
    "f_max [N]",
    "model",
    "parameters",
    "axes",
)
"""Columns of a file, in the order of the writer; the reader accepts any order."""

_REQUIRED = ("name", "link", "x", "y", "z")
_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
_UNITS = {"x": _METRES, "y": _METRES, "z": _METRES, "f_min": {"N": 1.0}, "f_max": {"N": 1.0}}
_KINDS: tuple[CableKind, ...] = get_args(CableKind)
_AXES: tuple[Axis, ...] = get_args(Axis)
_ROLES: tuple[Role, ...] = get_args(Role)
_HEADER = re.compile(r"(?P<name>[a-z_]+) *(?:[\[(](?P<unit>[a-z]+)[\])])?", re.IGNORECASE)
_MAX_NUMBER = 10**6


def read_csv(
    data: bytes, links: Collection[str] | None = None, file: Path | None = None
) -> tuple[MuscleTable, list[Finding]]:
    """Return the muscle table of a CSV file.

    The delimiter may be comma, semicolon or tab. The encoding may be UTF-8, or UTF-16 with a byte
    order mark.

    Args:
        data: Content of the file.
        links: Names of all links; None to accept any name.
        file: Path of the file, for the findings.

    Returns:
        The table and the findings on the file. Lines with an error are not in the table.
    """
    reader = _Reader(file, links)
    text = reader.decoded(data)
    if text is not None:
        reader.read(text)
    return reader.table(), reader.findings


@dataclass
class _Reader:
    """Reader of one CSV file, with the data read so far."""

    file: Path | None
    links: Collection[str] | None
    findings: list[Finding] = field(default_factory=list)
    rows: dict[str, MuscleSnapshot] = field(default_factory=dict)
    given: dict[str, dict[str, str]] = field(default_factory=dict)
    points: list[PointRow] = field(default_factory=list)
    others: list[PointRow] = field(default_factory=list)
    units: Mapping[str, float] = field(default_factory=dict)
    decimal_comma: bool = False
    line: int = 0

    def error(self, code: str, message: str) -> None:
        self.report("error", code, message)

    def report(self, severity: Severity, code: str, message: str) -> None:
        name = str(self.file or "")
        found = Finding(severity, code, message, Subject("file", name), self.file, self.line)
        self.findings.append(found)

    def decoded(self, data: bytes) -> str | None:
        wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
        try:
            return data.decode("utf-16" if wide else "utf-8-sig")
        except UnicodeDecodeError:
            self.line = 1
            self.error("bad-encoding", "is not UTF-8; save it as 'CSV UTF-8'")
            return None

    def read(self, text: str) -> None:
        first = text.split("\n", 1)[0]
        delimiter = max(",;\t", key=first.count)
        self.decimal_comma = delimiter != ","
        lines = self.records(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter))
        columns = self.header(next(lines, []))
        if columns is None:
            return
        for cells in lines:
            if len(cells) > len(columns) and any(cells[len(columns) :]):
                message = f"has {len(cells)} cells, the first line has {len(columns)}"
                self.error("bad-line", message)
            elif any(cells):
                self.record(dict(zip(columns, cells, strict=False)))

    def records(self, reader: Iterator[list[str]]) -> Iterator[list[str]]:
        """Yield the cells of each record; `line` is set to the first line of the record."""
        end = 0
        while True:
            self.line = end + 1
            try:
                cells = next(reader, None)
            except csv.Error as error:
                self.error("bad-line", f"cannot be read: {error}")
                return
            if cells is None:
                return
            end = reader.line_num  # type: ignore[attr-defined]
            yield [cell.strip() for cell in cells]

    def header(self, cells: list[str]) -> list[str] | None:
        known = [_column(column)[0] for column in COLUMNS]
        columns, units = [], {}
        for cell in cells:
            name, unit = _column(cell)
            columns.append(name)
            if name not in known:
                if cell:
                    self.report("warning", "unknown-column", f"column {cell!r} is ignored")
                continue
            factors = _UNITS.get(name, {})
            if unit and unit not in factors:
                message = f"column {cell!r}: the unit must be one of {', '.join(factors) or 'none'}"
                self.error("bad-unit", message)
            units[name] = factors.get(unit, 1.0)
        self.units = units
        missing = [name for name in _REQUIRED if name not in columns]
        if missing:
            message = f"has no column {', '.join(missing)}; the first line must name the columns"
            self.error("missing-column", message)
            return None
        return columns

    def record(self, cells: Mapping[str, str]) -> None:
        given, name = cells.get("role") or "via", cells.get("name") or ""
        role = next((role for role in _ROLES if role == given), None)
        if not name:
            self.error("missing-name", "has no name")
        elif role is None:
            self.error("bad-role", f"role must be via, task or marker, not {given!r}")
        elif role == "via":
            self.via(name, cells)
        else:
            self.other(role, name, cells)

    def other(self, role: Role, name: str, cells: Mapping[str, str]) -> None:
        """Read a task point or marker."""
        place = self.place(cells)
        if place is None:
            return
        given = cells.get("axes", "").split() if role == "task" else []
        axes = tuple(axis for axis in _AXES if axis in given)
        unknown = [axis for axis in given if axis not in _AXES]
        if unknown:
            self.error("bad-axes", f"axes: {unknown[0]!r} is not one of {', '.join(_AXES)}")
        elif any((point.role, point.name) == (role, name) for point in self.others):
            kind = "task point" if role == "task" else "marker"
            self.error("duplicate-name", f"{kind} {name!r} exists already")
        else:
            link, position = place
            axes = axes or POSITIONS if role == "task" else ()
            self.others.append(PointRow(role, link, name=name, axes=axes, position=position))

    def via(self, name: str, cells: Mapping[str, str]) -> None:
        self.muscle(name, cells)
        if not any(cells.get(key) for key in ("number", "link", "x", "y", "z")):
            return
        place = self.place(cells)
        mine = [point.number for point in self.points if point.muscle == name]
        number = self.number(cells.get("number", ""), max(mine, default=-1) + 1)
        if number in mine:
            self.error("duplicate-number", f"muscle {name!r} already has a point {number}")
        elif place is not None and number is not None:
            link, position = place
            self.points.append(PointRow("via", link, name, number, position=position))

    def number(self, text: str, default: int) -> int | None:
        if not text:
            return default
        try:
            number = int(text)
        except ValueError:
            number = -1
        if not 0 <= number <= _MAX_NUMBER:
            self.error("bad-number", f"number must be 0, 1, 2, ..., not {text!r}")
            return None
        return number

    def place(self, cells: Mapping[str, str]) -> tuple[str, Vector3] | None:
        link = cells.get("link", "")
        if not link:
            self.error("missing-link", "has no link")
            return None
        if self.links is not None and link not in self.links and link != WORLD:
            self.error("unknown-link", UnknownNameError("link", link, self.links).what)
            return None
        x, y, z = (self.float(key, cells.get(key, "")) for key in ("x", "y", "z"))
        if x is None or y is None or z is None:
            return None
        return link, (x, y, z)

    def float(self, key: str, text: str) -> float | None:
        number = _float(text.replace(",", ".") if self.decimal_comma else text)
        if number is None or not (math.isfinite(number) or (key == "f_max" and number > 0)):
            self.error("bad-number", f"{key} must be a number, not {text!r}")
            return None
        return number * self.units.get(key, 1.0)

    def muscle(self, name: str, cells: Mapping[str, str]) -> None:
        """Read the properties of a muscle; they must be equal in all of its lines."""
        keys = ("color", "f_min", "f_max", "model", "parameters")
        new = {key: cells[key] for key in keys if cells.get(key)}
        before = self.given.setdefault(name, {})
        for key, text in new.items():
            if before.get(key, text) != text:
                message = f"{key} of muscle {name!r} is {text!r} here and {before[key]!r} before"
                self.error("contradiction", message)
                return
        row = self.rows.get(name, MuscleSnapshot(name, ""))
        for key in [key for key in new if key not in before]:
            changed = self.property(row, key, new[key])
            row = changed or row
            before[key] = new[key]
        self.rows[name] = row

    def property(self, row: MuscleSnapshot, key: str, text: str) -> MuscleSnapshot | None:
        if key == "color":
            if not COLOR.fullmatch(text):
                self.error("bad-color", f"color must be #rrggbb, not {text!r}")
                return None
            return replace(row, color=text.lower())
        if key == "model":
            kind = next((kind for kind in _KINDS if kind == text), None)
            if kind is None:
                message = f"model must be one of {', '.join(_KINDS)}, not {text!r}"
                self.error("bad-model", message)
                return None
            return replace(row, model=kind)
        if key == "parameters":
            return self.parameters(row, text)
        number = self.float(key, text)
        if number is None:
            return None
        return replace(row, f_min=number) if key == "f_min" else replace(row, f_max=number)

    def parameters(self, row: MuscleSnapshot, text: str) -> MuscleSnapshot | None:
        pairs = [pair.partition("=") for pair in text.split()]
        values = [_float(v.replace(",", ".") if self.decimal_comma else v) for _, _, v in pairs]
        named = [(name, v) for (name, *_), v in zip(pairs, values, strict=True) if name]
        numbers = {name: v for name, v in named if v is not None and math.isfinite(v)}
        if len(numbers) != len(pairs):
            self.error("bad-parameters", f"parameters must be name=number ..., not {text!r}")
            return None
        return replace(row, parameters=numbers)

    def table(self) -> MuscleTable:
        table = MuscleTable()
        for row in self.rows.values():
            table = table.with_muscle(row if row.color else replace(row, color=table.next_color()))
        order = {name: i for i, name in enumerate(self.rows)}
        points = sorted(self.points, key=lambda p: (order[p.muscle], p.number))
        return replace(table, points=tuple(points), others=by_name(self.others))


def _column(header: str) -> tuple[str, str]:
    """Return name and unit of a column; the whole header if it has a different form."""
    match = _HEADER.fullmatch(header)
    return (match["name"].lower(), match["unit"] or "") if match else (header, "")


def _float(text: str) -> float | None:
    try:
        return float(text) if "_" not in text else None
    except ValueError:
        return None
