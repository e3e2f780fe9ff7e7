"""Tab with all muscles."""

from __future__ import annotations

from ....muscles.path import path_of
from ....snapshot import MuscleSnapshot
from ...dialogs import Cell, Input, number
from ..model import muscles
from ..model.model import MuscleModel
from .columns import Column, Rows, text_cell, with_chosen
from .properties import MODELS

TAB = Input(
    "tab_all",
    "tab",
    "All",
    children=(
        Input(
            "all",
            "table",
            "Muscles",
            "All muscles, in the order of their forces.",
            columns=("Name", "Min. [N]", "Max. [N]", "Muscle law", "Points, length"),
            widths=(4, 2, 2, 4, 4),
            rows=16,
            children=(
                Input(
                    "paste",
                    "button",
                    "Paste",
                    "Imports cells copied from a spreadsheet, including points. Muscles, task "
                    "points and markers with the same names are replaced.",
                ),
                Input("copy", "button", "Copy", "Copies all points for a spreadsheet."),
                Input("csv_import", "button", "Import ...", "Imports a CSV file."),
                Input("csv_export", "button", "Export ...", "Writes all points to a CSV file."),
            ),
        ),
    ),
)


def _name(model: MuscleModel, index: int) -> str:
    return model.table.rows[index].name


def _size(model: MuscleModel, row: MuscleSnapshot) -> Cell:
    count, path = len(model.table.points_of(row.name)), path_of(model.table, row.name)
    return Cell(f"{count}, {path.length_text}")


TABLES = {
    "all": Rows(
        lambda model: model.table.rows,
        (
            Column(
                lambda _, row: text_cell(row.name),
                lambda m, i, value: muscles.rename(m, value, _name(m, i)),
            ),
            Column(
                lambda _, row: text_cell(f"{row.f_min:g}"),
                lambda m, i, value: muscles.change(m, _name(m, i), f_min=number(value)),
            ),
            Column(
                lambda _, row: text_cell(f"{row.f_max:g}"),
                lambda m, i, value: muscles.change(m, _name(m, i), f_max=number(value)),
            ),
            Column(
                lambda _, row: Cell(row.model, with_chosen(MODELS, row.model)),
                lambda m, i, value: muscles.change_law(m, _name(m, i), value),
            ),
            Column(_size),
        ),
    ),
}
