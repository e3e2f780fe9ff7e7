"""Fusion's command inputs, built from the data of a dialog, and their values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import adsk.core

from .dialogs import Dialog, Input

_LARGEST = 1e9
_HEAD = "head"


@dataclass(frozen=True, slots=True)
class Cell:
    """What one cell of a table shows.

    Attributes:
        value: A text that is read, or the item that is chosen, or a number.
        options: What there is to choose from, if it is a drop-down.
        editable: Whether the user may write in it.
    """

    value: str | int
    options: tuple[str, ...] = ()
    editable: bool = False


class CellEdit(NamedTuple):
    """A cell of a table that the user has changed, and what it holds."""

    table: str
    row: int
    column: int
    value: Any


class Inputs:
    """The inputs of an open dialog, by id.

    Attributes:
        written: Id of the input that the user is writing in: its text is not replaced meanwhile.
    """

    def __init__(self, command: Any, dialog: Dialog) -> None:
        self.written = ""
        self._by_id: dict[str, Any] = {}
        self._tables: dict[str, _Table] = {}
        self._texts: dict[str, str] = {}
        for item in dialog.inputs:
            self._add(command.commandInputs, item)

    def __getitem__(self, name: str) -> Any:
        return self._by_id[name]

    def _add(self, inputs: Any, item: Input) -> Any:
        added = _MAKERS[item.kind](inputs, item)
        self._by_id[item.id] = added
        if item.tooltip:
            added.tooltip = item.label or item.id
            added.tooltipDescription = item.tooltip
        for child in item.children:
            below = inputs if item.kind == "table" else added.children
            made = self._add(below, child)
            if item.kind == "table":
                added.addToolbarCommandInput(made)
        if item.kind == "table":
            self._tables[item.id] = _Table(added, item)
        return added

    def value(self, name: str) -> Any:
        """What an input holds: a text, number or truth; the chosen item's name of a drop-down."""
        item = self._by_id[name]
        if isinstance(item, adsk.core.DropDownCommandInput):
            return item.selectedItem.name if item.selectedItem else ""
        return item.value

    def set(self, name: str, value: str | float | bool) -> None:
        """Lets an input hold something else."""
        item = self._by_id[name]
        if isinstance(item, adsk.core.TextBoxCommandInput):
            if self._texts.get(name) != value:
                self._texts[name] = str(value)
                item.formattedText = _html(str(value))
        elif name != self.written and item.value != value:
            item.value = value

    def choose(self, name: str, options: Sequence[str], chosen: str) -> None:
        """What there is to choose from in a drop-down, and what is chosen."""
        _fill(self._by_id[name].listItems, options, chosen)

    def checked(self, name: str) -> list[str]:
        """The ticked items of a drop-down with check boxes."""
        items = self._by_id[name].listItems
        every = [items.item(i) for i in range(items.count)]
        return [item.name for item in every if item.isSelected]

    def check(self, name: str, options: Sequence[str], checked: Sequence[str]) -> None:
        """The items of a drop-down with check boxes, and which are ticked."""
        items = self._by_id[name].listItems
        names = [items.item(i).name for i in range(items.count)]
        if names != list(options) or self.checked(name) != [n for n in names if n in checked]:
            items.clear()
            for option in options:
                items.add(option, option in checked)

    def picked(self, name: str) -> list[tuple[Any, Any]]:
        """What the user has picked, as entities and places; the selection is cleared."""
        item = self._by_id[name]
        picks = [item.selection(i) for i in range(item.selectionCount)]
        pairs = [(pick.entity, pick.point) for pick in picks]
        if pairs:
            item.clearSelection()
        return pairs

    def fill(self, name: str, rows: Sequence[Sequence[Cell]], selected: int | None = None) -> None:
        """The rows of a table; the same row stays selected if `selected` is None."""
        self._tables[name].fill(rows, selected)

    def selected(self, name: str) -> int:
        """The selected row of a table; -1 if none is."""
        return self._tables[name].selected()

    def cell(self, changed: Any) -> CellEdit | None:
        """Where an input is in a table, and what it holds now; None if it is no table's."""
        table, _, place = str(changed.id).partition("__")
        if not place or table not in self._tables or _HEAD in place:
            return None
        _, row, column = map(int, place.split("__"))
        if isinstance(changed, adsk.core.DropDownCommandInput):
            value = changed.selectedItem.name
        else:
            value = changed.value
        self._tables[table].note(row, column, value)
        return CellEdit(table, row, column, value)


class _Table:
    """A table with a line of headings; its rows are made anew only if they change."""

    def __init__(self, table: Any, item: Input) -> None:
        self._table = table
        self._id = item.id
        self._rows: list[list[Cell]] | None = None
        self._generation = 0
        for column, title in enumerate(item.columns):
            self._put(0, column, f"{_HEAD}__{column}", Cell(title))

    def fill(self, rows: Sequence[Sequence[Cell]], selected: int | None) -> None:
        cells = [list(row) for row in rows]
        keep = self.selected() if selected is None else selected
        if cells != self._rows:
            self._rows = cells
            self._generation += 1  # an id is never used twice
            while self._table.rowCount > 1:
                self._table.deleteRow(self._table.rowCount - 1)
            for i, row in enumerate(cells):
                for j, cell in enumerate(row):
                    self._put(i + 1, j, f"{self._generation}__{i}__{j}", cell)
        self._table.selectedRow = keep + 1 if 0 <= keep < len(cells) else -1

    def note(self, row: int, column: int, value: str | int) -> None:
        """The user has written that: a row that holds it already is not made anew."""
        if self._rows is not None and row < len(self._rows):
            self._rows[row][column] = replace(self._rows[row][column], value=value)

    def selected(self) -> int:
        return max(int(self._table.selectedRow) - 1, -1)

    def _put(self, row: int, column: int, place: str, cell: Cell) -> None:
        inputs, name = self._table.commandInputs, f"{self._id}__{place}"
        made: Any
        if cell.options:
            style = adsk.core.DropDownStyles.TextListDropDownStyle
            made = inputs.addDropDownCommandInput(name, "", style)
            _fill(made.listItems, cell.options, str(cell.value))
        elif isinstance(cell.value, int):
            made = inputs.addIntegerSpinnerCommandInput(name, "", 0, 10**6, 1, cell.value)
        else:
            made = inputs.addStringValueInput(name, "", cell.value)
            made.isReadOnly = not cell.editable
        self._table.addCommandInput(made, row, column)


def _fill(items: Any, options: Sequence[str], chosen: str) -> None:
    names = [items.item(i).name for i in range(items.count)]
    if names != list(options):
        items.clear()
        for option in options:
            items.add(option, option == chosen)
        return
    for i, option in enumerate(options):
        if option == chosen and not items.item(i).isSelected:
            items.item(i).isSelected = True


def _html(text: str) -> str:
    """A text as the box shows it: names may hold what HTML reads as its own."""
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return text.replace("\n", "<br/>")


def _selection(inputs: Any, item: Input) -> Any:
    made = inputs.addSelectionInput(item.id, item.label, item.prompt)
    for name in item.filters:
        made.addSelectionFilter(name)
    made.setSelectionLimits(0, 0)
    if hasattr(made, "isUseCurrentSelections"):  # since November 2024
        made.isUseCurrentSelections = False
    return made


def _dropdown(inputs: Any, item: Input) -> Any:
    style = adsk.core.DropDownStyles.TextListDropDownStyle
    made = inputs.addDropDownCommandInput(item.id, item.label, style)
    _fill(made.listItems, item.options, str(item.value))
    return made


def _choices(inputs: Any, item: Input) -> Any:
    style = adsk.core.DropDownStyles.CheckBoxDropDownStyle
    return inputs.addDropDownCommandInput(item.id, item.label, style)


def _string(inputs: Any, item: Input) -> Any:
    made = inputs.addStringValueInput(item.id, item.label, str(item.value))
    made.isReadOnly = item.read_only
    return made


def _number(inputs: Any, item: Input) -> Any:
    value = float(item.value or 0.0)
    return inputs.addFloatSpinnerCommandInput(item.id, item.label, "", 0.0, _LARGEST, 1.0, value)


def _integer(inputs: Any, item: Input) -> Any:
    value = int(item.value or 0)
    return inputs.addIntegerSpinnerCommandInput(item.id, item.label, 0, 10**6, 1, value)


def _check(inputs: Any, item: Input) -> Any:
    return inputs.addBoolValueInput(item.id, item.label, True, "", bool(item.value))


def _text(inputs: Any, item: Input) -> Any:
    return inputs.addTextBoxCommandInput(item.id, item.label, "", item.rows, True)


def _table(inputs: Any, item: Input) -> Any:
    ratio = ":".join(map(str, item.widths))
    made = inputs.addTableCommandInput(item.id, item.label, len(item.columns), ratio)
    made.minimumVisibleRows = min(3, item.rows)
    made.maximumVisibleRows = item.rows
    return made


_MAKERS: dict[str, Callable[[Any, Input], Any]] = {
    "tab": lambda inputs, item: inputs.addTabCommandInput(item.id, item.label),
    "group": lambda inputs, item: inputs.addGroupCommandInput(item.id, item.label),
    "selection": _selection,
    "dropdown": _dropdown,
    "choices": _choices,
    "string": _string,
    "number": _number,
    "integer": _integer,
    "check": _check,
    "button": lambda inputs, item: inputs.addBoolValueInput(item.id, item.label, False, "", False),
    "text": _text,
    "table": _table,
}
