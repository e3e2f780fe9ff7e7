"""Tab with task points and markers."""

from __future__ import annotations

from ....muscles.rows import PointRow
from ...dialogs import Cell, Input
from ..model import points
from ..model.model import MuscleModel
from .columns import Column, Rows, link_cell, text_cell
from .muscles import POINTS

TASK, MARKER = "Task point", "Marker"

TAB = Input(
    "tab_others",
    "tab",
    "Task points, markers",
    children=(
        Input(
            "other_role",
            "dropdown",
            "Pick",
            "Task points are controlled or reported; markers are tracked by cameras.",
            options=(TASK, MARKER),
            value=TASK,
        ),
        Input(
            "other_pick",
            "selection",
            "Points",
            "Click the points, as on the tab Muscles; their names can be edited in the table.",
            filters=POINTS,
            prompt="Pick a task point or marker",
        ),
        Input(
            "others",
            "table",
            "Points",
            "All task points and markers.",
            columns=("Type", "Name", "Link"),
            widths=(2, 3, 3),
            rows=8,
            children=(Input("other_delete", "button", "Delete", "Deletes the selected point."),),
        ),
    ),
)


def _link(model: MuscleModel, point: PointRow) -> Cell:
    return Cell(f"not found: {point.lost}") if point.lost else link_cell(model, point.link)


TABLES = {
    "others": Rows(
        lambda model: model.table.others,
        (
            Column(lambda _, point: Cell(TASK if point.role == "task" else MARKER)),
            Column(lambda _, point: text_cell(point.name), points.rename_other),
            Column(_link, points.move_other),
        ),
    ),
}
