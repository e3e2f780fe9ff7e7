"""View of the pending table in the dialog's inputs."""

from __future__ import annotations

from ...muscles.rows import NAMED_COLORS, TaskRow
from ...robot.model.laws.law import Parameter
from ...robot.model.muscle import CableModel
from ...robot.model.pose import Vector3
from ...robot.model.robot import WORLD
from ...robot.model.tension_laws import law_of
from ..inputs import Cell, Inputs
from .dialog import (
    INSIDE,
    MARKER,
    MODELS,
    NEW_MUSCLE,
    NO_SURFACE,
    OF_PART,
    OTHER_COLOR,
    SIDES,
    TASK,
)
from .pending import PendingTable
from .problems import hints, problems

SHOWN = 12
"""So many lines of a kind fit into the status."""


def show(pending: PendingTable, inputs: Inputs, selected: int | None = None) -> None:
    """Let the inputs show the pending table; with None the same point stays selected."""
    _show_muscle(pending, inputs, selected)
    _show_all(pending, inputs)
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
            Cell(position_text(p.position), editable=True),
        )
        for p in points
    ]
    inputs.fill("points", cells, selected)
    inputs.set("length", f"{len(points)} points, {1000 * pending.length():.1f} mm")
    row = pending.table.row(pending.muscle)
    if row is None:
        return
    inputs.set("muscle_name", row.name)
    palette = {color: name for name, color in NAMED_COLORS.items()}
    inputs.choose("palette", (*NAMED_COLORS, OTHER_COLOR), palette.get(row.color, OTHER_COLOR))
    inputs.set("color", row.color)
    inputs.set("f_min", row.f_min)
    inputs.set("f_max", min(row.f_max, 1e9))
    inputs.choose("model", _models(row.model), row.model.kind)
    given = dict(row.model.parameters)
    known = {p.name: p for p in law_of(row.model).parameters}
    inputs.fill(
        "parameters",
        [
            (
                Cell(name),
                Cell(f"{given[name]:g}" if name in given else "", editable=True),
                Cell(_about(known[name]) if name in known else "unknown to this model"),
            )
            for name in parameter_names(row.model)
        ],
    )


def _models(model: CableModel) -> tuple[str, ...]:
    """What there is to choose from; also what the muscle has now."""
    return MODELS if model.kind in MODELS else (*MODELS, model.kind)


def parameter_names(model: CableModel) -> list[str]:
    """The parameters of a muscle's model, then those that it does not know."""
    names = [p.name for p in law_of(model).parameters]
    return list(dict.fromkeys([*names, *(name for name, _ in model.parameters)]))


def position_text(position: Vector3) -> str:
    """A position as the table shows it, in [mm]."""
    return ", ".join(f"{1000 * v:.1f}" for v in position)


def _about(p: Parameter) -> str:
    default = "" if p.default is None else f", {p.default:g}"
    return f"{p.unit}{default}: {p.meaning}"


def _show_all(pending: PendingTable, inputs: Inputs) -> None:
    table = pending.table
    cells = [
        (
            Cell(row.name, editable=True),
            Cell(f"{row.f_min:g}", editable=True),
            Cell(f"{row.f_max:g}", editable=True),
            Cell(row.model.kind, _models(row.model)),
            Cell(f"{len(table.points_of(row.name))}, {1000 * pending.length(row.name):.1f} mm"),
        )
        for row in table.rows
    ]
    inputs.fill("all", cells)


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
