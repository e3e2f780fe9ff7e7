"""Dialog of Define muscles: its tabs and what they show."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..dialogs import Dialog, Input
from .model.model import MuscleModel
from .tabs import all_muscles, motion, muscles, others, tools, wraps

if TYPE_CHECKING:
    from ..inputs import CellEdit, Inputs

SHOWN = 12
"""Maximum number of problems in the status."""

DIALOG = Dialog(
    id="cardsflowDefineMuscles",
    folder="define_muscles",
    name="Define muscles",
    tooltip="Defines muscles by the points that they pass through.",
    description="Each point belongs to the link of the clicked part. Muscles, task points, markers "
    "and wrap surfaces are stored in the design. The rest of the design is not changed. One undo "
    "reverts everything.",
    size=(520, 640),
    edits=True,
    inputs=(
        muscles.TAB,
        all_muscles.TAB,
        wraps.TAB,
        others.TAB,
        tools.TAB,
        motion.TAB,
        Input("undo", "button", "Undo", "Reverts the last edit in this dialog."),
        Input("redo", "button", "Redo", "Repeats the edit that was undone last."),
        Input("status", "text", "Status", "Last action, and why OK is disabled.", rows=4),
    ),
)

_TABLES = {**muscles.TABLES, **all_muscles.TABLES, **wraps.TABLES, **others.TABLES}


def edit_cell(model: MuscleModel, edit: CellEdit) -> None:
    """Handle an edited cell.

    Raises:
        InputError: The value is invalid for the cell.
    """
    edited = _TABLES[edit.table].columns[edit.column].edited
    if edited is not None:
        edited(model, edit.row, edit.value)


def show(model: MuscleModel, inputs: Inputs, selected: int | None = None) -> None:
    """Show the model in the inputs; the selected point is unchanged if None."""
    for tab in (muscles, wraps, tools):
        tab.show(model, inputs)
    for name, rows in _TABLES.items():
        inputs.fill(name, rows.cells(model), selected if name == "points" else None)
    wrong = model.problems()
    lines = [model.message] if model.message else []
    lines += [f"OK is disabled: {text}" for text in wrong[:SHOWN]]
    if not wrong:
        lines += model.hints()[:SHOWN]
    inputs.set("status", "\n".join(lines) or "Pick the first point.")
