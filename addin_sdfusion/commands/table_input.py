"""Table of command inputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import adsk.core

from .dialogs import Cell, Input
from .input_values import cell_html, fill_items

HEAD = "head"
"""Beginning of the place of an input in the header row."""


class TableInput:
    """Table with a header row, whose rows are updated in place.

    Deleting a row deletes its inputs, which is not allowed while an event of one of them is
    handled.
    """

    def __init__(self, table: Any, item: Input, icons: Path) -> None:
        self._table = table
        self.id = item.id
        self._icons = icons
        self._rows: list[list[Cell]] = []
        self._rows_made = 0
        for column, title in enumerate(item.columns):
            self._put(0, column, f"{HEAD}__{column}", Cell(title))

    def fill(self, rows: Sequence[Sequence[Cell]], selected: int | None, written: str) -> None:
        """Set the rows, as described for `Inputs.fill`, except a text that is being edited."""
        cells = [list(row) for row in rows]
        keep = self.selected() if selected is None else selected
        same = 0  # number of rows that existing inputs can show
        for old, new in zip(self._rows, cells, strict=False):
            if not all(a.same_input(b) for a, b in zip(old, new, strict=True)):
                break
            same += 1
        for i in range(same):
            for j, (old_cell, cell) in enumerate(zip(self._rows[i], cells[i], strict=True)):
                if old_cell == cell:
                    continue
                item = self._table.getInputAtPosition(i + 1, j)
                if cell.editable and item.id == written:
                    cells[i][j] = old_cell  # keep the text that the user is editing
                else:
                    self._show(item, cell)
        for i in reversed(range(same, len(self._rows))):
            self._table.deleteRow(i + 1)
        for i in range(same, len(cells)):
            self._rows_made += 1  # ids must be unique
            for j, cell in enumerate(cells[i]):
                self._put(i + 1, j, f"{self._rows_made}__{i}__{j}", cell)
        self._rows = cells
        row = keep + 1 if 0 <= keep < len(cells) else -1
        if self._table.selectedRow != row:
            self._table.selectedRow = row

    def _show(self, item: Any, cell: Cell) -> None:
        if cell.icon:
            item.tooltipDescription = str(cell.value)
        elif cell.options:
            fill_items(item.listItems, cell.options, str(cell.value))
        elif cell.lines:
            item.formattedText = cell_html(cell)
        elif item.value != cell.value:
            item.value = cell.value

    def note(self, row: int, column: int, value: str | int) -> None:
        """Store a value entered by the user, so that its row is not created again."""
        if row < len(self._rows):
            self._rows[row][column] = replace(self._rows[row][column], value=value)

    def shows(self, row: int, column: int, value: Any) -> bool:
        """Return whether a cell shows this value."""
        return row < len(self._rows) and bool(self._rows[row][column].value == value)

    def selected(self) -> int:
        """Return the selected row, or -1."""
        return max(int(self._table.selectedRow) - 1, -1)

    def _put(self, row: int, column: int, place: str, cell: Cell) -> None:
        inputs, name = self._table.commandInputs, f"{self.id}__{place}"
        field: Any
        if cell.icon:
            field = inputs.addBoolValueInput(name, "", False, str(self._icons / cell.icon), False)
            field.tooltipDescription = str(cell.value)
        elif cell.lines:
            field = inputs.addTextBoxCommandInput(name, "", cell_html(cell), cell.lines, True)
        elif cell.options:
            style = adsk.core.DropDownStyles.TextListDropDownStyle
            field = inputs.addDropDownCommandInput(name, "", style)
            fill_items(field.listItems, cell.options, str(cell.value))
        elif isinstance(cell.value, int):
            field = inputs.addIntegerSpinnerCommandInput(name, "", 0, 10**6, 1, cell.value)
        else:
            field = inputs.addStringValueInput(name, "", cell.value)
            field.isReadOnly = not cell.editable
        self._table.addCommandInput(field, row, column)
