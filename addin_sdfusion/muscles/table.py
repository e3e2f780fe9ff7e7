"""Table of the muscles of a design: its rows and edits.

Positions are in the root frame of the design at the pose of the design, in [m]. A table is
immutable: an edit returns a new one, in which the points of every muscle are numbered without gaps.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from ..robot.errors import InputError, UnknownNameError
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
"""Colours assigned to new muscles."""

SAME = 1e-7
"""Maximum distance of two points that are considered identical, in [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PointRow(PointUse):
    """The stored use of a point with its position; the occurrence is the one that contains it.

    Attributes:
        position: In the root frame, in [m].
        entity: Identifier of the point in the CAD system; empty if unknown.
        lost: Reason why the point was not found; empty if it was found. A lost point is stored
            unchanged until the user deletes it.
    """

    position: Vector3
    entity: str = ""
    lost: str = ""

    @property
    def use(self) -> PointUse:
        """The use to store on the point."""
        return PointUse(**{f.name: getattr(self, f.name) for f in fields(PointUse)})

    def on_link(self, link: str) -> PointRow:
        """Return the point fixed to another link.

        A construction point that the add-in created is created again in the component of the other
        link, so that it moves with that link.

        Raises:
            InputError: The point was not found.
        """
        self.require_found()
        moved = replace(self, link=link)
        return replace(moved, entity="", occurrence="", made=False) if self.made else moved

    def require_found(self) -> None:
        """Raise an InputError if the point was not found."""
        if self.lost:
            raise InputError(f"This point is not found: {self.lost}. Delete it or pick it again.")


@dataclass(frozen=True, slots=True, kw_only=True)
class WrapRow(SurfaceUse):
    """The stored use of a wrap surface, with its shape."""

    face: SurfaceSnapshot

    @property
    def use(self) -> SurfaceUse:
        """The use to store on the face."""
        return SurfaceUse(**{f.name: getattr(self, f.name) for f in fields(SurfaceUse)})

    @property
    def lost(self) -> str:
        """Reason why the face was not found; empty if it was found."""
        return self.face.lost


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

    # Import from a file

    def merge(self, new: MuscleTable) -> MuscleTable:
        """Return the table merged with a table read from a file, which replaces equal names.

        A new point at the position of an existing point on the same link replaces that point and
        keeps its construction point.
        """
        table = self
        for row in new.rows:
            table = table.with_muscle(row)
        of = {row.name: self.points_of(row.name) for row in table.rows}
        for row in new.rows:
            free = list(of[row.name])
            of[row.name] = tuple(_match_existing_point(p, free) for p in new.points_of(row.name))
        others = {(point.role, point.name): [point] for point in self.others}
        for point in new.others:
            key = point.role, point.name
            others[key] = [_match_existing_point(point, others.get(key, []))]
        return replace(
            table,
            points=tuple(p for row in table.rows for p in of[row.name]),
            others=by_name(point for (point,) in others.values()),
        )

    # Links

    def used_links(self) -> list[str]:
        """Return the links of all points and wrap surfaces that were found."""
        links = {p.link for p in (*self.points, *self.others) if not p.lost}
        return sorted(links | {w.link for w in self.wraps if not w.lost}, key=natural_key)

    def replace_link(self, old: str, new: str, link_of: Mapping[str, str]) -> MuscleTable:
        """Return the table with all points and wrap surfaces of one link on another link.

        Args:
            old: The link to replace.
            new: The other link; empty for the link of the occurrence of each point.
            link_of: Link of each occurrence, by path.
        """

        def link(occurrence: str) -> str:
            return new or link_of.get(occurrence, old)

        def move(point: PointRow) -> PointRow:
            if point.link != old or point.lost:
                return point
            there = link(point.occurrence)
            is_there = there == link_of.get(point.occurrence)
            return replace(point, link=there) if is_there else point.on_link(there)

        return replace(
            self,
            points=tuple(map(move, self.points)),
            others=tuple(map(move, self.others)),
            wraps=tuple(
                replace(w, link=link(w.occurrence)) if w.link == old and not w.lost else w
                for w in self.wraps
            ),
        )

    # Checks

    def problems(self, links: Collection[str]) -> list[str]:
        """Return a sentence for every problem that prevents writing the table into a design.

        Args:
            links: Names of all links of the design.
        """
        return [*self._muscle_problems(), *self._wrap_problems(), *self._link_problems(links)]

    def hints(self) -> list[str]:
        """Return hints on incomplete muscles."""
        return [
            f"{row.name} needs at least two points."
            for row in self.rows
            if len(self.points_of(row.name)) < 2
        ]

    def bad_uses(self) -> Iterator[tuple[WrapRow, WrapUse]]:
        """Yield uses of wrap surfaces with an unknown muscle or point."""
        for wrap in self.wraps:
            for use in wrap.muscles:
                if use.after not in [p.number for p in self.points_of(use.muscle)][:-1]:
                    yield wrap, use

    def _muscle_problems(self) -> Iterator[str]:
        for row in self.rows:
            if not COLOR.fullmatch(row.color):
                yield f"{row.name}: the colour must be #rrggbb, not {row.color!r}."
            if not row.f_min >= 0.0:
                yield f"{row.name}: the minimum force must not be negative."
            if not row.f_min <= row.f_max:
                yield f"{row.name}: the maximum force must not be less than the minimum force."
        for kind, points in (("task points", self.tasks), ("markers", self.markers)):
            counts = Counter(point.name for point in points)
            if counts.pop("", 0):
                yield f"One of the {kind} has no name; enter one."
            for name in sorted(name for name, count in counts.items() if count > 1):
                yield f"Two {kind} are called {name}; rename one."

    def _wrap_problems(self) -> Iterator[str]:
        for wrap, use in self.bad_uses():
            yield (
                f"Wrap surface {wrap.name}: point {use.after} of {use.muscle} does not exist or is "
                "the last point; choose the point in the table."
            )

    def _link_problems(self, links: Collection[str]) -> Iterator[str]:
        kinds = {"task": "Task point", "marker": "Marker"}
        located = [
            *((f"Point {p.number} of {p.muscle}", p.link) for p in self.points if not p.lost),
            *((f"{kinds[p.role]} {p.name}", p.link) for p in self.others if not p.lost),
            *((f"Wrap surface {w.name}", w.link) for w in self.wraps if not w.lost),
        ]
        for what, link in located:
            if link not in links and link != WORLD:
                problem = UnknownNameError("link", link, links).what
                yield f"{what}: {problem}; choose its link in the table."


def change_uses(wrap: WrapRow, edit: Callable[[int, WrapUse], WrapUse | None]) -> WrapRow:
    """Return a wrap surface with edited uses; a use is deleted if `edit` returns None."""
    uses = [edit(i, use) for i, use in enumerate(wrap.muscles)]
    return replace(wrap, muscles=tuple(use for use in uses if use is not None))


def by_name(points: Any) -> tuple[PointRow, ...]:
    """Return task points and markers in the order of a table."""
    order = ("task", "marker")
    return tuple(
        sorted(points, key=lambda p: (order.index(p.role), natural_key(p.name), p.occurrence))
    )


def free_name(names: Sequence[str], rows: Sequence[MuscleSnapshot | PointUse | SurfaceUse]) -> str:
    """Return the first unused name; the number of names must exceed the number of rows."""
    taken = {row.name for row in rows}
    return next(name for name in names if name not in taken)


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
