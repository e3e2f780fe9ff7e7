"""Edits of the table of muscles: each gives a new table, numbered without gaps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ..robot.model.pose import Vector3
from ..snapshot import WrapUse
from .rows import COLORS, MuscleRow, MuscleTable, ViaPointRow, WrapRow


def renumbered(table: MuscleTable) -> MuscleTable:
    """The same table with the numbers of every muscle in a row, from its smallest one."""
    for row in table.rows:
        table = with_points(table, row.name, table.points_of(row.name))
    return table


def with_points(
    table: MuscleTable, muscle: str, points: Sequence[ViaPointRow], first: int | None = None
) -> MuscleTable:
    """The table with the points of a muscle replaced.

    Wrap surfaces stay after the point that they came after; where that is gone, after the one that
    took its place.

    Args:
        table: The table.
        muscle: Name of the muscle; it has a row.
        points: In order; their numbers are those of before, or -1 for a new one.
        first: Number of the first point; the smallest of the numbers of before if None.
    """
    before = [point.number for point in table.points_of(muscle)]
    start = min([number for number in before if number >= 0], default=0)
    start = start if first is None else first
    after = [replace(p, muscle=muscle, number=start + i) for i, p in enumerate(points)]
    moved = {p.number: q.number for p, q in zip(reversed(points), reversed(after), strict=True)}
    last = max(len(after) - 2, 0) + start
    kept = sorted(number for number in moved if number >= 0)

    def place(number: int) -> int:
        if number not in moved:  # it is gone: the one before it in the order of before
            earlier = [moved[n] for n in kept if n < number]
            return min(max(earlier, default=start), last)
        return min(moved[number], last)

    rest = {row.name: table.points_of(row.name) for row in table.rows}
    rest[muscle] = tuple(after)
    wraps = tuple(_with_uses(wrap, muscle, place) for wrap in table.wraps)
    return replace(
        table, points=tuple(p for row in table.rows for p in rest[row.name]), wraps=wraps
    )


def _with_uses(wrap: WrapRow, muscle: str, place: Callable[[int], int]) -> WrapRow:
    uses = tuple(
        replace(use, after=place(use.after)) if use.muscle == muscle else use
        for use in wrap.muscles
    )
    return replace(wrap, muscles=uses)


def insert_point(table: MuscleTable, point: ViaPointRow, index: int | None = None) -> MuscleTable:
    """A point added to its muscle, which is added as well if it is new."""
    if table.row(point.muscle) is None:
        table = with_muscle(table, MuscleRow(point.muscle, next_color(table)))
    points = list(table.points_of(point.muscle))
    points.insert(len(points) if index is None else index, replace(point, number=-1))
    return with_points(table, point.muscle, points)


def delete_point(table: MuscleTable, muscle: str, index: int) -> MuscleTable:
    """The table without a point; the muscle stays, with or without points."""
    points = list(table.points_of(muscle))
    del points[index]
    first = min((point.number for point in table.points_of(muscle)), default=0)
    return with_points(table, muscle, points, first)


def move_point(table: MuscleTable, muscle: str, index: int, by: int) -> MuscleTable:
    """A point moved along its muscle; not beyond the ends.

    Wrap surfaces stay where they are along the muscle.
    """
    points = list(table.points_of(muscle))
    numbers = [point.number for point in points]
    target = min(max(index + by, 0), len(points) - 1)
    points.insert(target, points.pop(index))
    ordered = [replace(p, number=n) for p, n in zip(points, numbers, strict=True)]
    return with_points(table, muscle, ordered)


def duplicate_point(
    table: MuscleTable, muscle: str, index: int, to: str | None = None
) -> MuscleTable:
    """A second point in the same place.

    Args:
        table: The table.
        muscle: Name of the muscle.
        index: Which of its points.
        to: Name of the muscle that gets it, at its end; the same one, next to the point, if None.
    """
    point = replace(table.points_of(muscle)[index], name="", made=False)
    if to is None or to == muscle:
        return insert_point(table, point, index + 1)
    return insert_point(table, replace(point, muscle=to))


def set_link(table: MuscleTable, muscle: str, index: int, link: str) -> MuscleTable:
    """A point fixed to another link.

    A construction point that the add-in made is made anew in the other link's component, so that it
    moves with that link.
    """
    points = list(table.points_of(muscle))
    points[index] = replace(points[index], link=link)
    if points[index].made:
        points[index] = replace(points[index], entity="", occurrence="", name="", made=False)
    return with_points(table, muscle, points)


def set_position(table: MuscleTable, muscle: str, index: int, position: Vector3) -> MuscleTable:
    """A point put to another place, in [m]; a construction point is made there."""
    points = list(table.points_of(muscle))
    free = replace(points[index], position=position, entity="", name="", made=False)
    points[index] = free
    return with_points(table, muscle, points)


def with_muscle(table: MuscleTable, row: MuscleRow) -> MuscleTable:
    """The table with a muscle added, or its properties replaced."""
    if table.row(row.name) is None:
        return replace(table, rows=(*table.rows, row))
    return replace(table, rows=tuple(row if r.name == row.name else r for r in table.rows))


def rename_muscle(table: MuscleTable, old: str, new: str) -> MuscleTable:
    """A muscle with another name, which no muscle has."""
    rows = tuple(replace(row, name=new) if row.name == old else row for row in table.rows)
    points = tuple(replace(p, muscle=new) if p.muscle == old else p for p in table.points)
    wraps = tuple(
        replace(wrap, muscles=tuple(_renamed(use, old, new) for use in wrap.muscles))
        for wrap in table.wraps
    )
    return replace(table, rows=rows, points=points, wraps=wraps)


def _renamed(use: WrapUse, old: str, new: str) -> WrapUse:
    return replace(use, muscle=new) if use.muscle == old else use


def delete_muscle(table: MuscleTable, muscle: str) -> MuscleTable:
    """The table without a muscle, its points and its wraps."""
    wraps = tuple(
        replace(wrap, muscles=tuple(use for use in wrap.muscles if use.muscle != muscle))
        for wrap in table.wraps
    )
    return replace(
        table,
        rows=tuple(row for row in table.rows if row.name != muscle),
        points=tuple(point for point in table.points if point.muscle != muscle),
        wraps=wraps,
    )


def new_muscle_name(table: MuscleTable) -> str:
    """`motorN` with the smallest N that no muscle has."""
    taken = {row.name for row in table.rows}
    return next(name for n in range(len(taken) + 1) if (name := f"motor{n}") not in taken)


def next_color(table: MuscleTable) -> str:
    """The colour that the fewest muscles have."""
    used = [row.color for row in table.rows]
    return min(COLORS, key=used.count)
