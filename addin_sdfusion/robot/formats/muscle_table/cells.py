"""Reader for the lines and cells of a muscle table, with findings about errors.

The delimiter may be comma, semicolon or tab; with the latter two, numbers may have a decimal comma.
The encoding may be UTF-8, or UTF-16 with a byte order mark.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ...errors import UnknownNameError
from ...finding import Finding, Severity, Subject
from ...model.pose import Vector3
from ...model.robot import WORLD

Cells = Mapping[str, str]
"""Cells of a line by column; columns without a cell are missing."""

_METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
_RADIANS = {"rad": 1.0, "deg": math.pi / 180.0}
_NEWTONS = {"N": 1.0}
_LENGTHS = ("x", "y", "z", "radius", "length", "half_axis_y", "half_axis_z")
_UNITS: dict[str, dict[str, float]] = {
    **dict.fromkeys(_LENGTHS, _METRES),
    **dict.fromkeys(("roll", "pitch", "yaw"), _RADIANS),
    **dict.fromkeys(("f_min", "f_max"), _NEWTONS),
}
_INFINITE = ("f_max", "length")
_HEADER = re.compile(r"(?P<name>[a-z_]+) *(?:[\[(](?P<unit>[a-z]+)[\])])?", re.IGNORECASE)
_MAX_NUMBER = 10**6


@dataclass
class CellReader:
    """Reader of one file.

    Attributes:
        file: Path of the file, for the findings.
        columns: Names of the known columns.
        required: Names of the required columns.
        links: Names of all links; None to accept any name.
        hint: Text after the message about missing columns.
        line: Number of the current line.
    """

    file: Path | None
    columns: Collection[str]
    required: Sequence[str]
    links: Collection[str] | None = None
    hint: str = ""
    findings: list[Finding] = field(default_factory=list)
    line: int = 1
    _units: dict[str, float] = field(default_factory=dict)
    _decimal_comma: bool = False

    def error(self, code: str, message: str) -> None:
        """Report an error in the current line."""
        self._report("error", code, message)

    def _report(self, severity: Severity, code: str, message: str) -> None:
        subject = Subject("file", str(self.file or ""))
        self.findings.append(Finding(severity, code, message, subject, self.file, self.line))

    def lines(self, data: bytes) -> Iterator[Cells]:
        """Yield the cells of each line after the header; `line` is the number of the line."""
        text = self._decoded(data)
        if text is None:
            return
        first = text.split("\n", 1)[0]
        delimiter = max(",;\t", key=first.count)
        self._decimal_comma = delimiter != ","
        records = self._records(csv.reader(io.StringIO(text, newline=""), delimiter=delimiter))
        columns = self._header(next(records, []))
        if columns is None:
            return
        for cells in records:
            if len(cells) > len(columns) and any(cells[len(columns) :]):
                message = f"has {len(cells)} cells, the first line has {len(columns)}"
                self.error("bad-line", message)
            elif any(cells):
                yield dict(zip(columns, cells, strict=False))

    def _decoded(self, data: bytes) -> str | None:
        wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
        try:
            return data.decode("utf-16" if wide else "utf-8-sig")
        except UnicodeDecodeError:
            self.error("bad-encoding", "is not UTF-8; save it as 'CSV UTF-8'")
            return None

    def _records(self, reader: Iterator[list[str]]) -> Iterator[list[str]]:
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

    def _header(self, cells: list[str]) -> list[str] | None:
        columns = []
        for cell in cells:
            name, unit = _column(cell)
            columns.append(name)
            if name not in self.columns:
                if cell:
                    message = f"column {cell!r} is ignored"
                    self._report("warning", "unknown-column", message)
                continue
            factors = _UNITS.get(name, {})
            if unit and unit not in factors:
                message = f"column {cell!r}: the unit must be one of {', '.join(factors) or 'none'}"
                self.error("bad-unit", message)
            self._units[name] = factors.get(unit, 1.0)
        missing = [name for name in self.required if name not in columns]
        if missing:
            message = f"has no column {', '.join(missing)}; the first line must name the columns"
            self.error("missing-column", message + self.hint)
            return None
        return columns

    def number(self, key: str, text: str) -> float | None:
        """Return a number in SI units; report an error and return None if it is invalid."""
        number = self._float(text)
        if number is None or not (math.isfinite(number) or (key in _INFINITE and number > 0)):
            self.error("bad-number", f"{key} must be a number, not {text!r}")
            return None
        return number * self._units.get(key, 1.0)

    def vector(self, cells: Cells, keys: tuple[str, str, str]) -> Vector3 | None:
        """Return three numbers in SI units, or None after an error."""
        x, y, z = (self.number(key, cells.get(key, "")) for key in keys)
        return None if x is None or y is None or z is None else (x, y, z)

    def integer(self, key: str, text: str) -> int | None:
        """Return a non-negative integer, or None after an error."""
        try:
            number = int(text)
        except ValueError:
            number = -1
        if not 0 <= number <= _MAX_NUMBER:
            self.error("bad-number", f"{key} must be 0, 1, 2, ..., not {text!r}")
            return None
        return number

    def word(self, key: str, text: str, allowed: Sequence[str]) -> bool:
        """Return whether a word is known; report an error otherwise."""
        if text not in allowed:
            self.error(f"bad-{key}", f"{key} must be one of {', '.join(allowed)}, not {text!r}")
        return text in allowed

    def place(self, cells: Cells) -> tuple[str, Vector3] | None:
        """Return link and position, or None after an error."""
        link = cells.get("link", "")
        if not link:
            self.error("missing-link", "has no link")
            return None
        if self.links is not None and link not in self.links and link != WORLD:
            self.error("unknown-link", UnknownNameError("link", link, self.links).problem)
            return None
        position = self.vector(cells, ("x", "y", "z"))
        return None if position is None else (link, position)

    def parameters(self, text: str) -> dict[str, float] | None:
        """Return numbers by name from `name=number ...`, or None after an error."""
        pairs = [pair.partition("=") for pair in text.split()]
        named = [(name, self._float(value)) for name, _, value in pairs if name]
        numbers = {name: v for name, v in named if v is not None and math.isfinite(v)}
        if len(numbers) != len(pairs):
            self.error("bad-parameters", f"parameters must be name=number ..., not {text!r}")
            return None
        return numbers

    def _float(self, text: str) -> float | None:
        try:
            plain = text.replace(",", ".") if self._decimal_comma else text
            return float(plain) if "_" not in plain else None
        except ValueError:
            return None


def _column(header: str) -> tuple[str, str]:
    """Return name and unit of a column; the whole header if it has a different form."""
    match = _HEADER.fullmatch(header)
    return (match["name"].lower(), match["unit"] or "") if match else (header, "")
