"""Table of the muscles of a design: its rows and edits.

Positions are in the root frame of the design at the pose of the design, in [m]. A table is
immutable: an edit returns a new one, in which the points of every muscle are numbered without gaps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from ..snapshot import DEFAULT_COLOR, MuscleSnapshot, WrapUse
from .point_names import natural_key
from .rows import PointRow, WrapRow, change_uses, free_name

NAMED_COLORS = {
    "Red": DEFAULT_COLOR,
    "Blue": "#1f77b4",
    "Green": "#2ca02c",
    "Orange": "#ff7f0e",
    "Purple": "#9467bd",
    "Cyan": "#17becf",
    "Pink": "#e377c2",
    "Brown": "#8c564b",
    "Olive": "#bcbd22",
    "Grey": "#7f7f7f",
}
COLORS = tuple(NAMED_COLORS.values())
"""Colours assigned to new muscles."""


@dataclass(frozen=True, slots=True)
class MuscleTable:
    """Muscles, task points, markers and wrap surfaces of a design.

    Attributes:
        rows: The muscles, in order; the names are unique.
        points: Via points, in the order of the muscles, then by number.
        others: Task points, by name, and markers, by name.
        wraps: Wrap surfaces, by name.
    """

    rows: tuple[MuscleSnapshot, ...] = ()
    points: tuple[PointRow, ...] = ()
    others: tuple[PointRow, ...] = ()
    wraps: tuple[WrapRow, ...] = ()

    @property
    def tasks(self) -> tuple[PointRow, ...]:
        """The task points."""
        return tuple(point for point in self.others if point.role == "task")

    @property
    def markers(self) -> tuple[PointRow, ...]:
        """The markers."""
        return tuple(point for point in self.others if point.role == "marker")

    def row(self, muscle: str) -> MuscleSnapshot | None:
        """Return the muscle of that name, or None."""
        return next((row for row in self.rows if row.name == muscle), None)

    def points_of(self, muscle: str) -> tuple[PointRow, ...]:
        """Return the via points of a muscle, in order."""
        return tuple(point for point in self.points if point.muscle == muscle)

    def wraps_of(self, muscle: str) -> tuple[tuple[WrapRow, WrapUse], ...]:
        """Return the surfaces that a muscle wraps over, in the order of its points."""
        uses = [(row, use) for row in self.wraps for use in row.muscles if use.muscle == muscle]
        return tuple(sorted(uses, key=lambda pair: (pair[1].after, natural_key(pair[0].name))))

    # Muscles

    def with_muscle(self, row: MuscleSnapshot) -> MuscleTable:
        """Return the table with a muscle added or its properties replaced."""
        if self.row(row.name) is None:
            return replace(self, rows=(*self.rows, row))
        return replace(self, rows=tuple(row if r.name == row.name else r for r in self.rows))

    def rename_muscle(self, old: str, new: str) -> MuscleTable:
        """Return the table with a muscle renamed; the new name must be unused."""
        return replace(
            self,
            rows=tuple(replace(r, name=new) if r.name == old else r for r in self.rows),
            points=tuple(replace(p, muscle=new) if p.muscle == old else p for p in self.points),
            wraps=self._wraps_with(old, lambda use: replace(use, muscle=new)),
        )

    def delete_muscle(self, muscle: str) -> MuscleTable:
        """Return the table without a muscle, its points and its wraps."""
        return replace(
            self,
            rows=tuple(row for row in self.rows if row.name != muscle),
            points=tuple(point for point in self.points if point.muscle != muscle),
            wraps=self._wraps_with(muscle, lambda use: None),
        )

    def new_muscle_name(self) -> str:
        """Return `motorN` with the smallest unused N."""
        return free_name([f"motor{n}" for n in range(len(self.rows) + 1)], self.rows)

    def next_color(self) -> str:
        """Return the least used colour."""
        used = [row.color for row in self.rows]
        return min(COLORS, key=used.count)

    # Via points

    def renumber(self) -> MuscleTable:
        """Return the table with points numbered without gaps from the smallest number."""
        table = self
        for row in self.rows:
            table = table.with_points(row.name, table.points_of(row.name))
        return table

    def with_points(
        self, muscle: str, points: Sequence[PointRow], first: int | None = None
    ) -> MuscleTable:
        """Return the table with the points of a muscle replaced.

        A wrap surface remains after the same point. If this point is deleted, the surface comes
        after the preceding point.

        Args:
            muscle: Name of the muscle, which must be in the table.
            points: Points in order, with their previous numbers, or -1 for a new point.
            first: Number of the first point; None for the smallest previous number.
        """
        before = [point.number for point in self.points_of(muscle)]
        start = min([number for number in before if number >= 0], default=0)
        start = start if first is None else first
        after = tuple(replace(p, muscle=muscle, number=start + i) for i, p in enumerate(points))
        moved = {p.number: q.number for p, q in zip(reversed(points), reversed(after), strict=True)}
        last = max(len(after) - 2, 0) + start

        def place(number: int) -> int:
            if number in moved:
                return min(moved[number], last)
            earlier = [moved[n] for n in moved if 0 <= n < number]  # the point is deleted
            return min(max(earlier, default=start), last)

        of = {row.name: self.points_of(row.name) for row in self.rows} | {muscle: after}
        return replace(
            self,
            points=tuple(point for row in self.rows for point in of[row.name]),
            wraps=self._wraps_with(muscle, lambda use: replace(use, after=place(use.after))),
        )

    def insert_point(self, point: PointRow, index: int | None = None) -> MuscleTable:
        """Return the table with a point added; a new muscle is added too."""
        table = self
        if self.row(point.muscle) is None:
            table = self.with_muscle(MuscleSnapshot(point.muscle, self.next_color()))
        points = list(table.points_of(point.muscle))
        points.insert(len(points) if index is None else index, replace(point, number=-1))
        return table.with_points(point.muscle, points)

    def duplicate_point(self, muscle: str, index: int) -> MuscleTable:
        """Return the table with a copy of a point after it, at the same position."""
        return self.insert_point(replace(self.points_of(muscle)[index], made=False), index + 1)

    def delete_point(self, muscle: str, index: int) -> MuscleTable:
        """Return the table without a point; a muscle without points remains in the table."""
        points = list(self.points_of(muscle))
        first = min(point.number for point in points)
        del points[index]
        return self.with_points(muscle, points, first)

    def move_point(self, muscle: str, index: int, by: int) -> MuscleTable:
        """Return the table with a point moved along its muscle, at most to an end.

        Wrap surfaces keep their position in the sequence of points.
        """
        points = list(self.points_of(muscle))
        numbers = [point.number for point in points]
        points.insert(min(max(index + by, 0), len(points) - 1), points.pop(index))
        ordered = [replace(p, number=n) for p, n in zip(points, numbers, strict=True)]
        return self.with_points(muscle, ordered)

    def change_point(
        self, muscle: str, index: int, edit: Callable[[PointRow], PointRow]
    ) -> MuscleTable:
        """Return the table with an edited point."""
        points = list(self.points_of(muscle))
        points[index] = edit(points[index])
        return self.with_points(muscle, points)

    # Wrap surfaces

    def change_wrap(self, name: str, edit: Callable[[WrapRow], WrapRow | None]) -> MuscleTable:
        """Return the table with an edited wrap surface; it is deleted if `edit` returns None."""
        edited = [edit(wrap) if wrap.name == name else wrap for wrap in self.wraps]
        return replace(self, wraps=tuple(wrap for wrap in edited if wrap is not None))

    def _wraps_with(
        self, muscle: str, edit: Callable[[WrapUse], WrapUse | None]
    ) -> tuple[WrapRow, ...]:
        """Return all wrap surfaces with edited uses of one muscle."""
        return tuple(
            change_uses(wrap, lambda _, use: edit(use) if use.muscle == muscle else use)
            for wrap in self.wraps
        )

    def bad_uses(self) -> Iterator[tuple[WrapRow, WrapUse]]:
        """Yield uses of wrap surfaces with an unknown muscle or point."""
        for wrap in self.wraps:
            for use in wrap.muscles:
                if use.after not in [p.number for p in self.points_of(use.muscle)][:-1]:
                    yield wrap, use
