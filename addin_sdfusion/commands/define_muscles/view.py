"""View of the edited table in the dialog's inputs."""

from __future__ import annotations

from ...muscles.table import NAMED_COLORS
from ...robot.model.laws.law import Parameter
from ...robot.model.pose import Vector3
from ...robot.model.robot import WORLD
from ...robot.model.tension_laws import law_of
from ...snapshot import MuscleSnapshot
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
from .editor import MuscleEditor

SHOWN = 12
"""So many lines of a kind fit into the status."""


def show(editor: MuscleEditor, inputs: Inputs, selected: int | None = None) -> None:
    """Let the inputs show the edited table; with None the same point stays selected."""
    _show_muscle(editor, inputs, selected)
    _show_all(editor, inputs)
    _show_wrap(editor, inputs)
    _show_others(editor, inputs)
    wrong = editor.table.problems(editor.links)
    lines = [editor.message] if editor.message else []
    lines += [f"OK is grey: {text}" for text in wrong[:SHOWN]]
    if not wrong:
        lines += editor.table.hints()[:SHOWN]
    inputs.set("status", "\n".join(lines) or "Pick the first point.")


def _show_muscle(editor: MuscleEditor, inputs: Inputs, selected: int | None) -> None:
    names = [row.name for row in editor.table.rows]
    inputs.choose("muscle", (*names, NEW_MUSCLE), editor.muscle or NEW_MUSCLE)
    inputs.choose("link", (OF_PART, *editor.links, WORLD), editor.link or OF_PART)
    points = editor.table.points_of(editor.muscle)
    cells = [
        (
            Cell(str(p.number)),
            _link_cell(editor, p.link),
            Cell(position_text(p.position), editable=True),
        )
        for p in points
    ]
    inputs.fill("points", cells, selected)
    inputs.set(
        "length", f"{len(points)} points, {1000 * editor.table.length(editor.muscle):.1f} mm"
    )
    row = editor.table.row(editor.muscle)
    if row is None:
        return
    inputs.set("muscle_name", row.name)
    palette = {color: name for name, color in NAMED_COLORS.items()}
    inputs.choose("palette", (*NAMED_COLORS, OTHER_COLOR), palette.get(row.color, OTHER_COLOR))
    inputs.set("color", row.color)
    inputs.set("f_min", row.f_min)
    inputs.set("f_max", min(row.f_max, 1e9))
    inputs.choose("model", _with(MODELS, row.model), row.model)
    given = row.parameters
    known = {p.name: p for p in law_of(row.cable_model).parameters}
    inputs.fill(
        "parameters",
        [
            (
                Cell(name),
                Cell(f"{given[name]:g}" if name in given else "", editable=True),
                Cell(_about(known[name]) if name in known else "unknown to this model"),
            )
            for name in parameter_names(row)
        ],
    )


def _with(options: tuple[str, ...], chosen: str) -> tuple[str, ...]:
    """What there is to choose from; also what is chosen now."""
    return options if chosen in options else (*options, chosen)


def _link_cell(editor: MuscleEditor, link: str) -> Cell:
    return Cell(link, _with((*editor.links, WORLD), link))


def parameter_names(row: MuscleSnapshot) -> list[str]:
    """The parameters of a muscle's model, then those that it does not know."""
    names = [p.name for p in law_of(row.cable_model).parameters]
    return list(dict.fromkeys([*names, *row.parameters]))


def position_text(position: Vector3) -> str:
    """A position as the table shows it, in [mm]."""
    return ", ".join(f"{1000 * v:.1f}" for v in position)


def _about(p: Parameter) -> str:
    default = "" if p.default is None else f", {p.default:g}"
    return f"{p.unit}{default}: {p.meaning}"


def _show_all(editor: MuscleEditor, inputs: Inputs) -> None:
    table = editor.table
    cells = [
        (
            Cell(row.name, editable=True),
            Cell(f"{row.f_min:g}", editable=True),
            Cell(f"{row.f_max:g}", editable=True),
            Cell(row.model, _with(MODELS, row.model)),
            Cell(f"{len(table.points_of(row.name))}, {1000 * table.length(row.name):.1f} mm"),
        )
        for row in table.rows
    ]
    inputs.fill("all", cells)


def _show_wrap(editor: MuscleEditor, inputs: Inputs) -> None:
    names = [wrap.name for wrap in editor.table.wraps]
    inputs.choose("wrap", names or (NO_SURFACE,), editor.wrap or NO_SURFACE)
    row = editor.wrap_row()
    if row is None:
        inputs.fill("wrap_uses", ())
        return
    inputs.set("wrap_name", row.name)
    inputs.choose("wrap_link", _with((*editor.links, WORLD), row.link), row.link)
    muscles = tuple(r.name for r in editor.table.rows)
    sides = {number: text for text, number in SIDES.items()}
    cells = [
        (
            Cell(use.muscle, _with(muscles, use.muscle)),
            Cell(use.after),
            Cell(INSIDE if use.inside else sides[use.side], (*SIDES, INSIDE)),
            Cell(use.turns),
        )
        for use in row.muscles
    ]
    inputs.fill("wrap_uses", cells)


def _show_others(editor: MuscleEditor, inputs: Inputs) -> None:
    cells = [
        (
            Cell(TASK if point.role == "task" else MARKER),
            Cell(point.name, editable=True),
            _link_cell(editor, point.link),
        )
        for point in editor.table.others
    ]
    inputs.fill("others", cells)
