"""View of the pending table in the dialog's inputs."""

from __future__ import annotations

from ...muscles.rows import TaskRow
from ...robot.model.robot import WORLD
from ..inputs import Cell, Inputs
from .dialog import INSIDE, MARKER, MODELS, NEW_MUSCLE, NO_SURFACE, OF_PART, SIDES, TASK
from .pending import PendingTable
from .problems import hints, problems

SHOWN = 12
"""So many lines of a kind fit into the status."""


def show(pending: PendingTable, inputs: Inputs, selected: int | None = None) -> None:
    """Let the inputs show the pending table; with None the same point stays selected."""
    _show_muscle(pending, inputs, selected)
    _show_wrap(pending, inputs)
    _show_others(pending, inputs)
    wrong = problems(pending.table, pending.links)
    lines = [pending.message] if pending.message else []
    lines += [f"OK is grey: {text}" for text in wrong[:SHOWN]]
    if not wrong:
        lines += hints(pending.table)[:SHOWN]
    inputs.set("status", "\n".join(lines) or "Pick the first point.")


def _show_muscle(pending: PendingTable, inputs: Inputs, selected: int | None) -> None:
    names = [row.name for row in pending.table.rows]
    inputs.choose("muscle", (*names, NEW_MUSCLE), pending.muscle or NEW_MUSCLE)
    links = (*pending.links, WORLD)
    inputs.choose("link", (OF_PART, *links), pending.link or OF_PART)
    points = pending.table.points_of(pending.muscle)
    cells = [
        (
            Cell(str(p.number)),
            Cell(p.link, links if p.link in links else (*links, p.link)),
            Cell(", ".join(f"{1000 * v:.1f}" for v in p.position)),
        )
        for p in points
    ]
    inputs.fill("points", cells, selected)
    inputs.set("length", f"{len(points)} points, {1000 * pending.length():.1f} mm")
    row = pending.table.row(pending.muscle)
    if row is None:
        return
    inputs.set("muscle_name", row.name)
    inputs.set("color", row.color)
    inputs.set("f_min", row.f_min)
    inputs.set("f_max", min(row.f_max, 1e9))
    inputs.choose("model", MODELS, row.model.kind)
    inputs.set("parameters", " ".join(f"{n}={v:g}" for n, v in row.model.parameters))


def _show_wrap(pending: PendingTable, inputs: Inputs) -> None:
    names = [wrap.name for wrap in pending.table.wraps]
    inputs.choose("wrap", names or (NO_SURFACE,), pending.wrap or NO_SURFACE)
    row = pending.wrap_row()
    links = (*pending.links, WORLD)
    if row is None:
        inputs.fill("wrap_uses", ())
        return
    inputs.set("wrap_name", row.name)
    inputs.choose("wrap_link", links if row.link in links else (*links, row.link), row.link)
    muscles = tuple(r.name for r in pending.table.rows)
    sides = {number: text for text, number in SIDES.items()}
    cells = [
        (
            Cell(use.muscle, muscles if use.muscle in muscles else (*muscles, use.muscle)),
            Cell(use.after),
            Cell(INSIDE if use.inside else sides[use.side], (*SIDES, INSIDE)),
            Cell(use.turns),
        )
        for use in row.muscles
    ]
    inputs.fill("wrap_uses", cells)


def _show_others(pending: PendingTable, inputs: Inputs) -> None:
    links = (*pending.links, WORLD)
    cells = [
        (
            Cell(TASK if isinstance(row, TaskRow) else MARKER),
            Cell(row.name, editable=True),
            Cell(row.link, links if row.link in links else (*links, row.link)),
        )
        for row in pending.others()
    ]
    inputs.fill("others", cells)
