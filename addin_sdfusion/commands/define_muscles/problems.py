"""Problems that keep a table of muscles from being written into the design."""

from __future__ import annotations

from collections.abc import Collection

from ...muscles.rows import MuscleTable
from ...robot.errors import UnknownNameError
from ...robot.model.robot import WORLD
from ...snapshot import COLOR


def problems(table: MuscleTable, links: Collection[str]) -> list[str]:
    """All problems of a pending table, a sentence each."""
    return [*_muscle_problems(table), *_wrap_problems(table), *_link_problems(table, links)]


def hints(table: MuscleTable) -> list[str]:
    """What is not finished yet."""
    return [
        f"{row.name} needs at least two points."
        for row in table.rows
        if len(table.points_of(row.name)) < 2
    ]


def _wrap_problems(table: MuscleTable) -> list[str]:
    return [
        f"Wrap surface {wrap.name}: {use.muscle} has no point {use.after} with another one after "
        "it; choose the point in the table."
        for wrap in table.wraps
        for use in wrap.muscles
        if use.after not in [p.number for p in table.points_of(use.muscle)][:-1]
    ]


def _muscle_problems(table: MuscleTable) -> list[str]:
    problems = []
    for row in table.rows:
        if not COLOR.fullmatch(row.color):
            problems.append(f"{row.name}: the colour must be #rrggbb, not {row.color!r}.")
        if not row.f_min >= 0.0:
            problems.append(f"{row.name}: the smallest force must be 0 N or more.")
        if not row.f_min <= row.f_max:
            problems.append(f"{row.name}: the largest force is less than the smallest one.")
    for kind, rows in (("task points", table.tasks), ("markers", table.markers)):
        names = [row.name for row in rows]
        if "" in names:
            problems.append(f"One of the {kind} has no name.")
        twice = sorted({name for name in names if name and names.count(name) > 1})
        problems += [f"Two {kind} are called {name}; rename one." for name in twice]
    return problems


def _link_problems(table: MuscleTable, links: Collection[str]) -> list[str]:
    rows = [
        *((f"Point {p.number} of {p.muscle}", p.link) for p in table.points),
        *((f"Task point {t.name}", t.link) for t in table.tasks),
        *((f"Marker {m.name}", m.link) for m in table.markers),
        *((f"Wrap surface {w.name}", w.link) for w in table.wraps),
    ]
    return [
        f"{what}: {UnknownNameError('link', link, links).what}; choose its link in the table."
        for what, link in rows
        if link not in links and link != WORLD
    ]
