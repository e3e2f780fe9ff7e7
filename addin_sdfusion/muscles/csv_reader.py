"""Reader for muscle tables in CSV files, as written by `csv_writer`."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import get_args

from ..robot.finding import Finding
from ..robot.formats.muscle_table.cells import CellReader, Cells
from ..robot.formats.muscle_table.lines import MuscleLines
from ..robot.model.robot import POSITIONS, Axis
from ..robot.records import Form
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

_KNOWN = (*(column.partition(" ")[0] for column in COLUMNS), "frame")
_REQUIRED = ("name", "link", "x", "y", "z")
_AXES: tuple[Axis, ...] = get_args(Axis)
_ROLES: tuple[Role, ...] = get_args(Role)


def read_csv(
    data: bytes, links: Collection[str] | None = None, file: Path | None = None
) -> tuple[MuscleTable, list[Finding]]:
    """Return the muscle table of a design from a CSV file; positions are in the root frame.

    Args:
        links: Names of all links; None to accept any name.
        file: Path of the file, for the findings.

    Returns:
        The table and the findings on the file. Lines with an error are not in the table.
    """
    cells = CellReader(file, _KNOWN, _REQUIRED, links)
    reader = _Reader(cells, MuscleLines(cells, {"color": Form("#rrggbb", COLOR.pattern)}))
    for line in cells.lines(data):
        reader.read(line)
    return reader.table(), cells.findings


@dataclass
class _Reader:
    """Reader of one CSV file, with the data read so far."""

    cells: CellReader
    muscles: MuscleLines
    others: list[PointRow] = field(default_factory=list)

    def read(self, cells: Cells) -> None:
        word, name = cells.get("role") or "via", cells.get("name") or ""
        role = next((role for role in _ROLES if role == word), None)
        if not name:
            self.cells.error("missing-name", "has no name")
        elif role is None:
            self.cells.error("bad-role", f"role must be via, task or marker, not {word!r}")
        elif cells.get("frame"):
            problem = "positions must be in the root frame, and the column frame empty"
            self.cells.error("bad-frame", f"{problem}; tables next to robot files use link frames")
        elif role == "via":
            self.muscles.read(name, cells)
        else:
            self.other(role, name, cells)

    def other(self, role: Role, name: str, cells: Cells) -> None:
        """Read a task point or marker."""
        place = self.cells.place(cells)
        if place is None:
            return
        words = cells.get("axes", "").split() if role == "task" else []
        axes = tuple(axis for axis in _AXES if axis in words)
        unknown = [axis for axis in words if axis not in _AXES]
        if unknown:
            message = f"axes: {unknown[0]!r} is not one of {', '.join(_AXES)}"
            self.cells.error("bad-axes", message)
        elif any((point.role, point.name) == (role, name) for point in self.others):
            kind = "task point" if role == "task" else "marker"
            self.cells.error("duplicate-name", f"{kind} {name!r} exists already")
        else:
            link, position = place
            axes = axes or POSITIONS if role == "task" else ()
            self.others.append(PointRow(role, link, name=name, axes=axes, position=position))

    def table(self) -> MuscleTable:
        table, points = MuscleTable(), []
        for name, properties in self.muscles.muscles.items():
            row = MuscleSnapshot(name, **({"color": table.next_color()} | properties))
            table = table.with_muscle(row)
            for p in self.muscles.points_of(name):
                points.append(PointRow("via", p.link, name, p.number, position=p.position))
        return replace(table, points=tuple(points), others=by_name(self.others))
