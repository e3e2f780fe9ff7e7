"""Merging of the table of a CSV file into the table of a design."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TypeVar

from .edits import with_muscle
from .point_names import natural_key
from .rows import MarkerRow, MuscleTable, PointRow, TaskRow, ViaPointRow

Row = TypeVar("Row", TaskRow, MarkerRow)


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
