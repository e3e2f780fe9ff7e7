"""Writer of the table of muscles as a CSV file, for spreadsheets.

One line a point. What belongs to the muscle is in the line of its first point; a muscle without
points has a line of its own. Positions are in the design's root frame. Wrap surfaces are faces and
not in the file.
"""

from __future__ import annotations

import csv
import io
import math
from dataclasses import replace
from typing import TypeVar

from .csv_reader import COLUMNS, read_csv
from .edits import with_muscle
from .point_names import natural_key
from .rows import MarkerRow, MuscleRow, MuscleTable, PointRow, TaskRow, ViaPointRow

__all__ = ["COLUMNS", "csv_text", "imported", "read_csv"]

Row = TypeVar("Row", TaskRow, MarkerRow)


def csv_text(table: MuscleTable) -> str:
    """The text of a file with all muscles, task points and markers."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\r\n")  # as RFC 4180 and spreadsheets have it
    writer.writerow(COLUMNS)
    for row in table.rows:
        points = table.points_of(row.name)
        muscle = (row.color, repr(row.f_min), repr(row.f_max), row.model.kind, _parameters(row))
        if not points:
            writer.writerow(("via", row.name, "", "", "", "", "", *muscle, ""))
        for i, p in enumerate(points):
            end = muscle if i == 0 else ("",) * len(muscle)
            writer.writerow(("via", row.name, p.number, p.link, *map(repr, p.position), *end, ""))
    for task in table.tasks:
        where = (task.link, *map(repr, task.position))
        writer.writerow(("task", task.name, "", *where, *[""] * 5, " ".join(task.axes)))
    for marker in table.markers:
        where = (marker.link, *map(repr, marker.position))
        writer.writerow(("marker", marker.name, "", *where, *[""] * 6))
    return stream.getvalue()


def _parameters(row: MuscleRow) -> str:
    return " ".join(f"{name}={value!r}" for name, value in row.model.parameters)


def imported(table: MuscleTable, new: MuscleTable, tolerance: float = 1e-7) -> MuscleTable:
    """The table with what was read from a file in the place of what has the same names.

    A point in the place of an earlier one of the same name and link is that point.

    Args:
        table: The table of the design.
        new: The table of the file.
        tolerance: How far apart two points may be to be the same, in [m].
    """
    for row in new.rows:
        table = with_muscle(table, row)
    points = {row.name: table.points_of(row.name) for row in table.rows}
    for row in new.rows:
        free = list(points[row.name])
        points[row.name] = tuple(
            _adopted_point(p, free, tolerance) for p in new.points_of(row.name)
        )
    tasks = {t.name: t for t in table.tasks}
    tasks |= {t.name: _adopted(t, tasks.get(t.name), tolerance) for t in new.tasks}
    markers = {m.name: m for m in table.markers}
    markers |= {m.name: _adopted(m, markers.get(m.name), tolerance) for m in new.markers}
    return replace(
        table,
        points=tuple(p for row in table.rows for p in points[row.name]),
        tasks=tuple(sorted(tasks.values(), key=lambda t: natural_key(t.name))),
        markers=tuple(sorted(markers.values(), key=lambda m: natural_key(m.name))),
    )


def _adopted_point(new: ViaPointRow, free: list[ViaPointRow], tolerance: float) -> ViaPointRow:
    """The new point as one of the old ones, which is taken out of `free`, if there is one."""
    near = [p for p in free if _same(p, new, tolerance)]
    if not near:
        return new
    old = min(near, key=lambda p: (abs(p.number - new.number), math.dist(p.position, new.position)))
    free.remove(old)
    return replace(old, number=new.number)


def _adopted(new: Row, old: Row | None, tolerance: float) -> Row:
    if old is None or not _same(old, new, tolerance):
        return new
    return replace(old, axes=new.axes) if isinstance(new, TaskRow) else old  # type: ignore[call-arg]


def _same(a: ViaPointRow | PointRow, b: ViaPointRow | PointRow, tolerance: float) -> bool:
    return a.link == b.link and math.dist(a.position, b.position) <= tolerance
