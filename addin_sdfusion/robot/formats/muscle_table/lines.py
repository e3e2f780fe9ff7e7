"""Lines of a muscle table: via points and muscles, which tables of designs and robots share."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, get_args

from ...model.muscle import CableKind
from ...model.pose import Vector3
from ...records import Form
from .cells import CellReader, Cells

PROPERTIES = ("f_min", "f_max", "model", "parameters")
"""Columns with properties of a muscle."""

_KINDS: tuple[str, ...] = get_args(CableKind)
_POINT = ("number", "link", "x", "y", "z")


class PointLine(NamedTuple):
    """Line with a via point: its muscle, number, link, position in [m], and options."""

    muscle: str
    number: int
    link: str
    position: Vector3
    options: str


@dataclass
class MuscleLines:
    """Muscles and via points in the lines of a table.

    Attributes:
        texts: Columns with texts that are properties of a muscle, and their formats.
        muscles: Specified properties of each muscle by name: `PROPERTIES` in SI units, the texts,
            and `options`.
        first_lines: Number of the first line of each muscle.
        points: Via points of each muscle by number, in the order of the file.
    """

    reader: CellReader
    texts: Mapping[str, Form] = field(default_factory=dict)
    muscles: dict[str, dict[str, Any]] = field(default_factory=dict)
    first_lines: dict[str, int] = field(default_factory=dict)
    points: dict[str, dict[int, PointLine]] = field(default_factory=dict)
    _properties: dict[str, dict[str, str]] = field(default_factory=dict)
    _next: dict[str, int] = field(default_factory=dict)

    def read(self, name: str, cells: Cells) -> None:
        """Read a line with the properties of a muscle, one of its points, or both."""
        self.first_lines.setdefault(name, self.reader.line)
        self._read_properties(name, cells, (*PROPERTIES, *self.texts))
        if not any(cells.get(key) for key in _POINT):
            self._read_properties(name, cells, ("options",))
            return
        place, points = self.reader.place(cells), self.points.setdefault(name, {})
        text = cells.get("number", "")
        number = self.reader.integer("number", text) if text else self._next.get(name, 0)
        if number in points:
            message = f"muscle {name!r} already has a point {number}"
            self.reader.error("duplicate-number", message)
        elif place is not None and number is not None:
            points[number] = PointLine(name, number, *place, cells.get("options", ""))
            self._next[name] = max(self._next.get(name, 0), number + 1)

    def points_of(self, muscle: str) -> list[PointLine]:
        """Return the points of a muscle, in order."""
        return [point for _, point in sorted(self.points.get(muscle, {}).items())]

    def _read_properties(self, name: str, cells: Cells, keys: tuple[str, ...]) -> None:
        """Read properties of a muscle; they must be equal in all of its lines."""
        new = {key: cells[key] for key in keys if cells.get(key)}
        before = self._properties.setdefault(name, {})
        values = self.muscles.setdefault(name, {})
        for key, text in new.items():
            if before.get(key, text) != text:
                message = f"{key} of muscle {name!r} is {text!r} here and {before[key]!r} before"
                self.reader.error("contradiction", message)
                return
        for key in [key for key in new if key not in before]:
            before[key] = new[key]
            value = self._property(key, new[key])
            if value is not None:
                values[key] = value

    def _property(self, key: str, text: str) -> Any:
        """Return a property, or None after an error."""
        form = self.texts.get(key)
        if form is not None:
            if re.fullmatch(form.pattern, text, re.ASCII):
                return text.lower()
            self.reader.error(f"bad-{key}", f"{key} must be {form.text}, not {text!r}")
            return None
        if key == "model":
            return text if self.reader.word("model", text, _KINDS) else None
        if key == "parameters":
            return self.reader.parameters(text)
        return text if key == "options" else self.reader.number(key, text)
