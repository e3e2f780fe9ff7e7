"""View of the pending table in the dialog's inputs."""

from __future__ import annotations

from ...muscles.rows import TaskRow
from ...robot.model.robot import WORLD
from ..inputs import Cell, Inputs
from .dialog import INSIDE, MARKER, MODELS, NEW_MUSCLE, NO_SURFACE, OF_PART, SIDES, TASK
from .problems import hints, problems
from .session import Session

SHOWN = 12
"""So many lines of a kind fit into the status."""


def show(session: Session, inputs: Inputs, selected: int | None = None) -> None:
    """Let the inputs show the pending table; with None the same point stays selected."""
    _show_muscle(session, inputs, selected)
    _show_wrap(session, inputs)
    _show_others(session, inputs)
    wrong = problems(session.table, session.links)
    lines = [session.message] if session.message else []
    lines += [f"OK is grey: {text}" for text in wrong[:SHOWN]]
    if not wrong:
        lines += hints(session.table)[:SHOWN]
    inputs.set("status", "\n".join(lines) or "Pick the first point.")


def _show_muscle(session: Session, inputs: Inputs, selected: int | None) -> None:
    names = [row.name for row in session.table.rows]
    inputs.choose("muscle", (*names, NEW_MUSCLE), session.muscle or NEW_MUSCLE)
    links = (*session.links, WORLD)
    inputs.choose("link", (OF_PART, *links), session.link or OF_PART)
    points = session.table.points_of(session.muscle)
    cells = [
        (
            Cell(str(p.number)),
            Cell(p.link, links if p.link in links else (*links, p.link)),
            Cell(", ".join(f"{1000 * v:.1f}" for v in p.position)),
        )
        for p in points
    ]
    inputs.fill("points", cells, selected)
    inputs.set("length", f"{len(points)} points, {1000 * session.length():.1f} mm")
    row = session.table.row(session.muscle)
    if row is None:
        return
    inputs.set("muscle_name", row.name)
    inputs.set("color", row.color)
    inputs.set("f_min", row.f_min)
    inputs.set("f_max", min(row.f_max, 1e9))
    inputs.choose("model", MODELS, row.model.kind)
    inputs.set("parameters", " ".join(f"{n}={v:g}" for n, v in row.model.parameters))


def _show_wrap(session: Session, inputs: Inputs) -> None:
    names = [wrap.name for wrap in session.table.wraps]
    inputs.choose("wrap", names or (NO_SURFACE,), session.wrap or NO_SURFACE)
    row = session.wrap_row()
    links = (*session.links, WORLD)
    if row is None:
        inputs.fill("wrap_uses", ())
        return
    inputs.set("wrap_name", row.name)
    inputs.choose("wrap_link", links if row.link in links else (*links, row.link), row.link)
    muscles = tuple(r.name for r in session.table.rows)
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


def _show_others(session: Session, inputs: Inputs) -> None:
    links = (*session.links, WORLD)
    cells = [
        (
            Cell(TASK if isinstance(row, TaskRow) else MARKER),
            Cell(row.name, editable=True),
            Cell(row.link, links if row.link in links else (*links, row.link)),
        )
        for row in session.others()
    ]
    inputs.fill("others", cells)
