"""Tables of inputs."""

# ruff: noqa: A002 -- the API's names

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..base import api
from ..state import world
from .input_selection import SelectionCommandInput
from .inputs import CommandInput, field


def _reject_changing(inputs: Iterable[Any]) -> None:
    """Reject the deletion of an input during its own event [reference]."""
    if any(data is world().changing for data in inputs):
        raise RuntimeError("3 : the input is deleted while its own event is handled")


@api("adsk.core")
class TableCommandInput(CommandInput):
    """Table; `cells` are the inputs by row and column. Rows below a deleted row move up."""

    minimumVisibleRows = field("minimumVisibleRows", "int", 2)
    maximumVisibleRows = field("maximumVisibleRows", "int", 4)
    columnRatio = field("columnRatio", "str", "")

    _cells = property(lambda self: self._data.fields["cells"])
    rowCount = property(lambda self: 1 + max((row for row, _ in self._cells), default=-1))

    @property
    def numberOfColumns(self) -> int:
        return 1 + max((column for _, column in self._cells), default=-1)

    @property
    def selectedRow(self) -> int:
        return self._data.fields.get("selectedRow", -1)

    @selectedRow.setter
    def selectedRow(self, value: int) -> None:
        if not -1 <= value < self.rowCount:
            raise RuntimeError("3 : invalid argument selectedRow")
        self._data.fields["selectedRow"] = value

    def addCommandInput(
        self, input: CommandInput, row: int, column: int, rowSpan: int = 0, columnSpan: int = 0
    ) -> bool:
        if isinstance(input, SelectionCommandInput):
            raise RuntimeError("3 : selections cannot be used within a table")
        if rowSpan or row < 0 or column < 0 or (row, column) in self._cells:
            raise RuntimeError("3 : invalid argument row, column or rowSpan")
        for k in range(columnSpan + 1):
            self._cells[row, column + k] = input._data
        input._data.table = self._data
        return True

    def addToolbarCommandInput(self, input: CommandInput) -> bool:
        self._data.fields["toolbar"].append(input._data)
        input._data.table = self._data
        return True

    def getInputAtPosition(self, row: int, column: int) -> Any:
        found = self._cells.get((row, column))
        return None if found is None else found.view()

    def deleteRow(self, row: int) -> bool:
        if not 0 <= row < self.rowCount:
            raise RuntimeError("3 : invalid argument row")
        _reject_changing(data for (r, _), data in self._cells.items() if r == row)
        for place in [place for place in self._cells if place[0] == row]:
            self._cells.pop(place).remove()
        moved = {(r - (r > row), c): data for (r, c), data in self._cells.items()}
        self._data.fields["cells"] = moved
        if self.selectedRow >= self.rowCount or self.selectedRow == row:
            self._data.fields["selectedRow"] = -1
        return True
