"""Problems of a muscle table that prevent writing it into a design."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator

from ....muscles.checks import table_findings
from ....muscles.table import MuscleTable
from ....robot.errors import UnknownNameError
from ....robot.model.robot import WORLD
from ....snapshot import COLOR


def problems(table: MuscleTable, links: Collection[str]) -> list[str]:
    """Return a sentence for every problem that prevents writing the table into a design."""
    return [*_muscle_problems(table), *_errors(table), *_link_problems(table, links)]


def _muscle_problems(table: MuscleTable) -> Iterator[str]:
    for row in table.rows:
        if not COLOR.fullmatch(row.color):
            yield f"{row.name}: the colour must be #rrggbb, not {row.color!r}."
        if not row.f_min >= 0.0:
            yield f"{row.name}: the minimum force must not be negative."
        if not row.f_min <= row.f_max:
            yield f"{row.name}: the maximum force must not be less than the minimum force."
    for kind, points in (("task points", table.tasks), ("markers", table.markers)):
        counts = Counter(point.name for point in points)
        if counts.pop("", 0):
            yield f"One of the {kind} has no name; enter one."
        for name in sorted(name for name, count in counts.items() if count > 1):
            yield f"Two {kind} are called {name}; rename one."


def _errors(table: MuscleTable) -> Iterator[str]:
    """Yield the errors that Check would report."""
    for finding in table_findings(table):
        if finding.is_error:
            yield f"{finding.message[0].upper()}{finding.message[1:]}."


def _link_problems(table: MuscleTable, links: Collection[str]) -> Iterator[str]:
    kinds = {"task": "Task point", "marker": "Marker"}
    located = [
        *((f"Point {p.number} of {p.muscle}", p.link) for p in table.points if not p.lost),
        *((f"{kinds[p.role]} {p.name}", p.link) for p in table.others if not p.lost),
        *((f"Wrap surface {w.name}", w.link) for w in table.wraps if not w.lost),
    ]
    for label, link in located:
        if link not in links and link != WORLD:
            problem = UnknownNameError("link", link, links).problem
            yield f"{label}: {problem}; choose its link in the table."
