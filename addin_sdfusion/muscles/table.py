"""Table of a design's muscles: its rows and their edits.

Positions are in the design's root frame at the design's pose, in [m]. A table never changes: an
edit gives a new one, in which the points of every muscle are numbered without gaps.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from ..robot.errors import UnknownNameError
from ..robot.model.pose import Vector3
from ..robot.model.robot import WORLD
from ..snapshot import (
    COLOR,
    DEFAULT_COLOR,
    MuscleSnapshot,
    PointUse,
    SurfaceSnapshot,
    SurfaceUse,
    WrapUse,
)
from .point_names import natural_key

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
"""Colours that muscles get in turn."""

SAME = 1e-7
"""How far apart two points may be to be the same, in [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PointRow(PointUse):
    """What a point is, as it is stored, and where; its occurrence is the one that holds it.

    Attributes:
        position: In the root frame, in [m].
        entity: What the CAD system's point is; empty if unknown.
    """

    position: Vector3
    entity: str = ""

    @property
    def use(self) -> PointUse:
        """What is stored on the point."""
        return PointUse(**{f.name: getattr(self, f.name) for f in fields(PointUse)})

    def on_link(self, link: str) -> PointRow:
        """Return the point fixed to another link.

        A construction point that the add-in made is made again in the other link's component, so
        that it moves with that link.
        """
        moved = replace(self, link=link)
        return replace(moved, entity="", occurrence="", made=False) if self.made else moved


@dataclass(frozen=True, slots=True, kw_only=True)
class WrapRow(SurfaceUse):
    """What a face that muscles wrap over is, as it is stored, and its shape."""

    face: SurfaceSnapshot

    @property
    def use(self) -> SurfaceUse:
        """What is stored on the face."""
        return SurfaceUse(self.name, self.link, self.muscles, self.occurrence)


@dataclass(frozen=True, slots=True)
class MuscleTable:
    """All that the user has defined on top of the bodies and joints.

    Attributes:
        rows: The muscles, in order; the names are unique.
        points: Via points: muscles in their order, then by number.
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

    def length(self, muscle: str) -> float:
        """Length of a muscle along its points, in [m]."""
        positions = [point.position for point in self.points_of(muscle)]
        return sum(map(math.dist, positions, positions[1:]))

    # Muscles

    def with_muscle(self, row: MuscleSnapshot) -> MuscleTable:
        """Return the table with a muscle added, or its properties replaced."""
        if self.row(row.name) is None:
            return replace(self, rows=(*self.rows, row))
        return replace(self, rows=tuple(row if r.name == row.name else r for r in self.rows))

    def rename_muscle(self, old: str, new: str) -> MuscleTable:
        """Return a muscle with another name, which no muscle has."""
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
        """`motorN` with the smallest N that no muscle has."""
        return free_name([f"motor{n}" for n in range(len(self.rows) + 1)], self.rows)

    def next_color(self) -> str:
        """Return the colour that the fewest muscles have."""
        used = [row.color for row in self.rows]
        return min(COLORS, key=used.count)

    # Via points

    def renumbered(self) -> MuscleTable:
        """Return the table with the numbers of every muscle in a row, from its smallest one."""
        table = self
        for row in self.rows:
            table = table.with_points(row.name, table.points_of(row.name))
        return table

    def with_points(
        self, muscle: str, points: Sequence[PointRow], first: int | None = None
    ) -> MuscleTable:
        """Return the table with the points of a muscle replaced.

        Wrap surfaces stay after the point that they came after; if that is gone, after the one
        that took its place.

        Args:
            muscle: Name of the muscle; it has a row.
            points: In order; their numbers are those of before, or -1 for a new one.
            first: Number of the first point; the smallest of the numbers of before if None.
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
            earlier = [moved[n] for n in moved if 0 <= n < number]  # it is gone
            return min(max(earlier, default=start), last)

        of = {row.name: self.points_of(row.name) for row in self.rows} | {muscle: after}
        return replace(
            self,
            points=tuple(point for row in self.rows for point in of[row.name]),
            wraps=self._wraps_with(muscle, lambda use: replace(use, after=place(use.after))),
        )

    def insert_point(self, point: PointRow, index: int | None = None) -> MuscleTable:
        """Return a point added to its muscle, which is added as well if it is new."""
        table = self
        if self.row(point.muscle) is None:
            table = self.with_muscle(MuscleSnapshot(point.muscle, self.next_color()))
        points = list(table.points_of(point.muscle))
        points.insert(len(points) if index is None else index, replace(point, number=-1))
        return table.with_points(point.muscle, points)

    def duplicate_point(self, muscle: str, index: int) -> MuscleTable:
        """Return a second point in the same place, next to the first."""
        return self.insert_point(replace(self.points_of(muscle)[index], made=False), index + 1)

    def delete_point(self, muscle: str, index: int) -> MuscleTable:
        """Return the table without a point; the muscle stays, with or without points."""
        points = list(self.points_of(muscle))
        first = min(point.number for point in points)
        del points[index]
        return self.with_points(muscle, points, first)

    def move_point(self, muscle: str, index: int, by: int) -> MuscleTable:
        """Return a point moved along its muscle; not beyond the ends.

        Wrap surfaces stay where they are along the muscle.
        """
        points = list(self.points_of(muscle))
        numbers = [point.number for point in points]
        points.insert(min(max(index + by, 0), len(points) - 1), points.pop(index))
        ordered = [replace(p, number=n) for p, n in zip(points, numbers, strict=True)]
        return self.with_points(muscle, ordered)

    def change_point(
        self, muscle: str, index: int, edit: Callable[[PointRow], PointRow]
    ) -> MuscleTable:
        """Return the table with other properties of a point."""
        points = list(self.points_of(muscle))
        points[index] = edit(points[index])
        return self.with_points(muscle, points)

    # Wrap surfaces

    def change_wrap(self, name: str, edit: Callable[[WrapRow], WrapRow | None]) -> MuscleTable:
        """Return the table with other properties of a wrap surface; None deletes it."""
        edited = [edit(wrap) if wrap.name == name else wrap for wrap in self.wraps]
        return replace(self, wraps=tuple(wrap for wrap in edited if wrap is not None))

    def _wraps_with(
        self, muscle: str, edit: Callable[[WrapUse], WrapUse | None]
    ) -> tuple[WrapRow, ...]:
        """Return all wrap surfaces, with other uses of one muscle."""
        return tuple(
            change_uses(wrap, lambda _, use: edit(use) if use.muscle == muscle else use)
            for wrap in self.wraps
        )

    # A table of a file

    def merged(self, new: MuscleTable) -> MuscleTable:
        """Return the table with what was read from a file in the place of what has the same names.

        A point in the place of an earlier one of the same name and link is that point.
        """
        table = self
        for row in new.rows:
            table = table.with_muscle(row)
        of = {row.name: self.points_of(row.name) for row in table.rows}
        for row in new.rows:
            free = list(of[row.name])
            of[row.name] = tuple(_adopted(p, free) for p in new.points_of(row.name))
        others = {(point.role, point.name): [point] for point in self.others}
        for point in new.others:
            key = point.role, point.name
            others[key] = [_adopted(point, others.get(key, []))]
        return replace(
            table,
            points=tuple(p for row in table.rows for p in of[row.name]),
            others=by_name(point for (point,) in others.values()),
        )

    # What is wrong

    def problems(self, links: Collection[str]) -> list[str]:
        """Return all that keeps the table from being written into a design, a sentence each.

        Args:
            links: Names of all links of the design.
        """
        return [*self._muscle_problems(), *self._wrap_problems(), *self._link_problems(links)]

    def hints(self) -> list[str]:
        """What is not finished yet."""
        return [
            f"{row.name} needs at least two points."
            for row in self.rows
            if len(self.points_of(row.name)) < 2
        ]

    def bad_uses(self) -> Iterator[tuple[WrapRow, WrapUse]]:
        """Wrap surfaces of muscles, or after points, that do not exist."""
        for wrap in self.wraps:
            for use in wrap.muscles:
                if use.after not in [p.number for p in self.points_of(use.muscle)][:-1]:
                    yield wrap, use

    def _muscle_problems(self) -> Iterator[str]:
        for row in self.rows:
            if not COLOR.fullmatch(row.color):
                yield f"{row.name}: the colour must be #rrggbb, not {row.color!r}."
            if not row.f_min >= 0.0:
                yield f"{row.name}: the smallest force must be 0 N or more."
            if not row.f_min <= row.f_max:
                yield f"{row.name}: the largest force is less than the smallest one."
        for kind, points in (("task points", self.tasks), ("markers", self.markers)):
            counts = Counter(point.name for point in points)
            if counts.pop("", 0):
                yield f"One of the {kind} has no name."
            for name in sorted(name for name, count in counts.items() if count > 1):
                yield f"Two {kind} are called {name}; rename one."

    def _wrap_problems(self) -> Iterator[str]:
        for wrap, use in self.bad_uses():
            yield (
                f"Wrap surface {wrap.name}: {use.muscle} has no point {use.after} with another one "
                "after it; choose the point in the table."
            )

    def _link_problems(self, links: Collection[str]) -> Iterator[str]:
        kinds = {"task": "Task point", "marker": "Marker"}
        located = [
            *((f"Point {p.number} of {p.muscle}", p.link) for p in self.points),
            *((f"{kinds[p.role]} {p.name}", p.link) for p in self.others),
            *((f"Wrap surface {w.name}", w.link) for w in self.wraps),
        ]
        for what, link in located:
            if link not in links and link != WORLD:
                problem = UnknownNameError("link", link, links).what
                yield f"{what}: {problem}; choose its link in the table."


def change_uses(wrap: WrapRow, edit: Callable[[int, WrapUse], WrapUse | None]) -> WrapRow:
    """Return a wrap surface with other uses; None deletes one."""
    uses = [edit(i, use) for i, use in enumerate(wrap.muscles)]
    return replace(wrap, muscles=tuple(use for use in uses if use is not None))


def by_name(points: Any) -> tuple[PointRow, ...]:
    """Task points and markers in the order of a table."""
    order = ("task", "marker")
    return tuple(
        sorted(points, key=lambda p: (order.index(p.role), natural_key(p.name), p.occurrence))
    )


def free_name(names: Sequence[str], rows: Sequence[MuscleSnapshot | PointUse | SurfaceUse]) -> str:
    """Return the first of the names that no row has; one more name than rows is enough."""
    taken = {row.name for row in rows}
    return next(name for name in names if name not in taken)


def _adopted(new: PointRow, free: list[PointRow]) -> PointRow:
    """The new point as one of the old ones, which is taken out of `free`, if there is one."""
    apart = {i: math.dist(old.position, new.position) for i, old in enumerate(free)}
    near = [i for i, old in enumerate(free) if old.link == new.link and apart[i] <= SAME]
    if not near:
        return new
    nearest = min(near, key=lambda i: (abs(free[i].number - new.number), apart[i]))
    return replace(free.pop(nearest), number=new.number, axes=new.axes)
