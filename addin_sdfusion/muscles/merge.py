"""Merger of a muscle table with a table read from a file."""

from __future__ import annotations

import math
from dataclasses import replace

from .rows import PointRow, by_name
from .table import MuscleTable

SAME = 1e-7
"""Maximum distance of two points that are considered identical, in [m]."""


def merge(old: MuscleTable, new: MuscleTable) -> MuscleTable:
    """Return a table merged with a table read from a file, which replaces equal names.

    A new point at the position of an existing point on the same link replaces that point and keeps
    its construction point.
    """
    table = old
    for row in new.rows:
        table = table.with_muscle(row)
    of = {row.name: old.points_of(row.name) for row in table.rows}
    for row in new.rows:
        free = list(of[row.name])
        of[row.name] = tuple(_match_existing_point(p, free) for p in new.points_of(row.name))
    others = {(point.role, point.name): [point] for point in old.others}
    for point in new.others:
        key = point.role, point.name
        others[key] = [_match_existing_point(point, others.get(key, []))]
    return replace(
        table,
        points=tuple(p for row in table.rows for p in of[row.name]),
        others=by_name(point for (point,) in others.values()),
    )


def _match_existing_point(new: PointRow, free: list[PointRow]) -> PointRow:
    """Return the new point merged with an old point at its position, which leaves `free`."""
    apart = {i: math.dist(old.position, new.position) for i, old in enumerate(free)}
    near = [
        i
        for i, old in enumerate(free)
        if old.link == new.link and apart[i] <= SAME and not old.lost
    ]
    if not near:
        return new
    nearest = min(near, key=lambda i: (abs(free[i].number - new.number), apart[i]))
    return replace(free.pop(nearest), number=new.number, axes=new.axes)
