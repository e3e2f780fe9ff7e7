"""View of the edited muscle table in the inputs of the dialog."""

from __future__ import annotations

from ...muscles.path import path_of
from ...muscles.table import NAMED_COLORS
from ...robot.model.robot import WORLD
from ..inputs import Inputs
from .dialog import MODELS, NEW_MUSCLE, NO_LINK, NO_SURFACE, OF_PART, OTHER_COLOR
from .editor import MuscleEditor
from .tables import TABLES, with_chosen

SHOWN = 12
"""Maximum number of problems in the status."""


def show(editor: MuscleEditor, inputs: Inputs, selected: int | None = None) -> None:
    """Show the edited table in the inputs; the selected point is unchanged if None."""
    _show_muscle(editor, inputs)
    _show_wrap(editor, inputs)
    for name, rows in TABLES.items():
        inputs.fill(name, rows.cells(editor), selected if name == "points" else None)
    wrong = editor.table.problems(editor.links)
    lines = [editor.message] if editor.message else []
    lines += [f"OK is disabled: {text}" for text in wrong[:SHOWN]]
    if not wrong:
        lines += editor.table.hints()[:SHOWN]
    inputs.set("status", "\n".join(lines) or "Pick the first point.")


def _show_muscle(editor: MuscleEditor, inputs: Inputs) -> None:
    names = [row.name for row in editor.table.rows]
    inputs.choose("muscle", (*names, NEW_MUSCLE), editor.muscle or NEW_MUSCLE)
    inputs.choose("link", (OF_PART, *editor.links, WORLD), editor.link or OF_PART)
    used = editor.table.used_links()
    old = inputs.value("old_link")
    inputs.choose("old_link", used or (NO_LINK,), old if old in used else (used or [NO_LINK])[0])
    new = inputs.value("new_link")
    choices = (OF_PART, *editor.links, WORLD)
    inputs.choose("new_link", choices, new if new in choices else OF_PART)
    count, path = len(editor.table.points_of(editor.muscle)), path_of(editor.table, editor.muscle)
    inputs.set("length", f"{count} points, {path.length_text}")
    row = editor.table.row(editor.muscle)
    if row is None:
        return
    inputs.set("muscle_name", row.name)
    palette = {color: name for name, color in NAMED_COLORS.items()}
    inputs.choose("palette", (*NAMED_COLORS, OTHER_COLOR), palette.get(row.color, OTHER_COLOR))
    inputs.set("color", row.color)
    inputs.set("f_min", row.f_min)
    inputs.set("f_max", min(row.f_max, 1e9))
    inputs.choose("model", with_chosen(MODELS, row.model), row.model)


def _show_wrap(editor: MuscleEditor, inputs: Inputs) -> None:
    names = [wrap.name for wrap in editor.table.wraps]
    inputs.choose("wrap", names or (NO_SURFACE,), editor.wrap or NO_SURFACE)
    row = editor.wrap_row()
    if row is not None:
        inputs.set("wrap_name", row.name)
        inputs.choose("wrap_link", with_chosen((*editor.links, WORLD), row.link), row.link)
