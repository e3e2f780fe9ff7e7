"""Reader for the muscles.csv next to a robot file."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar, cast, get_args

from ...errors import InputError
from ...finding import Finding, Subject
from ...limits import XML_ELEMENTS
from ...model.muscle import Side, WrapShape
from ...model.pose import Vector3
from .cells import CellReader, Cells
from .document import MuscleDocument, MuscleRecord, PointRecord, SurfaceRecord, WrapRecord
from .lines import MuscleLines
from .options import MuscleOptions, PointOptions, WrapOptions, read_options
from .write import COLUMNS

_REQUIRED = ("name", "frame", "link", "x", "y", "z")
_HINT = (
    ". Next to a robot file, positions are in link frames, and the column frame contains the word "
    "link; a table for the add-in or `import-cad` must be in another folder"
)
_ROLES = ("via", "wrap", "surface")
_ANGLES = ("roll", "pitch", "yaw")
_HALF_AXES = ("half_axis_y", "half_axis_z")
_ZERO: Vector3 = (0.0, 0.0, 0.0)
_SIDES: dict[str, Side] = {"": 0, "0": 0, "1": 1, "+1": 1, "-1": -1}
_ANSWERS = {"": False, "no": False, "yes": True}
_SHAPES: tuple[str, ...] = get_args(WrapShape)

Value = TypeVar("Value")


@dataclass(frozen=True)
class MuscleTableReading:
    """Contents of a muscles.csv.

    Attributes:
        document: Muscles and wrap surfaces, without the lines that have an error.
        lines: Number of the first line of each muscle and wrap surface.
    """

    document: MuscleDocument
    findings: tuple[Finding, ...]
    lines: Mapping[Subject, int]


def read_table(data: bytes, links: Collection[str], file: Path) -> MuscleTableReading:
    """Read a muscles.csv."""
    columns = [column.partition(" ")[0] for column in COLUMNS]
    cells = CellReader(file, columns, _REQUIRED, links, _HINT)
    reader = _Reader(cells, MuscleLines(cells))
    for k, line in enumerate(cells.lines(data)):
        if k == XML_ELEMENTS:
            cells.error("large-table", f"contains more than {XML_ELEMENTS} lines")
            break
        reader.read(line)
    return MuscleTableReading(reader.document(), tuple(cells.findings), reader.lines())


@dataclass
class _Reader:
    """Reader of one file, with the data read so far; wraps are stored with their lines."""

    cells: CellReader
    muscles: MuscleLines
    wraps: dict[str, list[tuple[int, WrapRecord]]] = field(default_factory=dict)
    surfaces: dict[str, tuple[int, SurfaceRecord]] = field(default_factory=dict)

    def read(self, cells: Cells) -> None:
        role, name = cells.get("role") or "via", cells.get("name") or ""
        frame = cells.get("frame") or "link"
        if not name:
            self.cells.error("missing-name", "has no name")
        elif frame != "link":
            problem = "frame must be link, since positions are in link frames"
            self.cells.error("bad-frame", f"{problem}; not {frame!r}")
        elif not self.cells.word("role", role, _ROLES):
            return
        elif role == "via":
            kind = PointOptions if cells.get("link") else MuscleOptions
            if self._has_valid_options(kind, cells):
                self.muscles.read(name, cells)
        elif role == "wrap":
            self._wrap(name, cells)
        else:
            self._surface(name, cells)

    def _has_valid_options(self, kind: type[Any], cells: Cells) -> bool:
        try:
            read_options(kind, cells.get("options", ""), "")
        except InputError as error:
            self.cells.error("bad-options", str(error).removeprefix(": "))
            return False
        return True

    def _wrap(self, muscle: str, cells: Cells) -> None:
        segment = self.cells.integer("number", cells.get("number", ""))
        turns = self.cells.integer("turns", cells.get("turns") or "0")
        side = self._choice("side", cells, _SIDES)
        inside = self._choice("inside", cells, _ANSWERS)
        valid = self._has_valid_options(WrapOptions, cells)
        surface, options = cells.get("surface", ""), cells.get("options", "")
        if not surface:
            self.cells.error("missing-surface", "has no surface")
        elif segment is None or turns is None or side is None or inside is None or not valid:
            return
        else:
            record = WrapRecord(surface, segment, side, turns, inside, options)
            self.wraps.setdefault(muscle, []).append((self.cells.line, record))

    def _surface(self, name: str, cells: Cells) -> None:
        place = self.cells.place(cells)
        shape = cells.get("shape", "")
        is_shape = self.cells.word("shape", shape, _SHAPES)
        radius = self.cells.number("radius", cells.get("radius", ""))
        rpy = self._vector(cells, _ANGLES) if any(map(cells.get, _ANGLES)) else _ZERO
        length = self.cells.number("length", cells.get("length") or "inf")
        halves = self._half_axes(cells)
        if name in self.surfaces:
            self.cells.error("duplicate-name", f"surface {name!r} exists already")
        elif place is None or radius is None or rpy is None or length is None or not is_shape:
            return
        else:
            link, position = place
            where = name, link, cast(WrapShape, shape), radius, position, rpy
            record = SurfaceRecord(*where, None if length == math.inf else length, halves)
            self.surfaces[name] = self.cells.line, record

    def _vector(self, cells: Cells, keys: tuple[str, str, str]) -> Vector3 | None:
        """Return three numbers; empty cells are 0."""
        return self.cells.vector({key: cells.get(key) or "0" for key in keys}, keys)

    def _half_axes(self, cells: Cells) -> tuple[float, float] | None:
        if not any(map(cells.get, _HALF_AXES)):
            return None
        y, z = (self.cells.number(key, cells.get(key, "")) for key in _HALF_AXES)
        return None if y is None or z is None else (y, z)

    def _choice(self, key: str, cells: Cells, options: Mapping[str, Value]) -> Value | None:
        text = cells.get(key, "")
        words = [option for option in options if option]
        return options[text] if not text or self.cells.word(key, text, words) else None

    def document(self) -> MuscleDocument:
        """Return the contents; report wraps of unknown muscles and after unknown points."""
        muscles = tuple(self._muscle(name) for name in self.muscles.muscles)
        for name, wraps in self.wraps.items():
            if name not in self.muscles.muscles:
                self.cells.line = wraps[0][0]
                self.cells.error("unknown-muscle", f"muscle {name!r} has no points")
        return MuscleDocument(muscles, tuple(surface for _, surface in self.surfaces.values()))

    def _muscle(self, name: str) -> MuscleRecord:
        properties = dict(self.muscles.muscles[name])
        law = properties.pop("model", "ideal")
        if properties.get("f_max") == math.inf:
            del properties["f_max"]
        points = self.muscles.points_of(name)
        numbers = [point.number for point in points]
        return MuscleRecord(
            name,
            law,
            points=tuple(PointRecord(p.link, p.position, p.options) for p in points),
            wraps=self._segments(name, numbers),
            **properties,
        )

    def _segments(self, muscle: str, numbers: list[int]) -> tuple[WrapRecord, ...]:
        """Return the wraps of a muscle, after points given by their indices."""
        index = {number: k for k, number in enumerate(numbers)}
        wraps = []
        for line, wrap in self.wraps.get(muscle, ()):
            if wrap.segment not in index:
                self.cells.line = line
                problem = f"muscle {muscle!r} has no point {wrap.segment}"
                self.cells.error("unknown-point", problem)
            else:
                wraps.append(replace(wrap, segment=index[wrap.segment]))
        return tuple(wraps)

    def lines(self) -> dict[Subject, int]:
        """Return the first line of each muscle and wrap surface."""
        muscles = {Subject("muscle", n): line for n, line in self.muscles.first_lines.items()}
        surfaces = {Subject("wrap_surface", n): k for n, (k, _) in self.surfaces.items()}
        return {**muscles, **surfaces}
