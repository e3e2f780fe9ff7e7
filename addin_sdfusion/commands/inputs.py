"""Fusion's command inputs, created from the definition of a dialog, and their values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import adsk.core

from ..fusion.notes import optional
from .dialogs import Cell, Dialog, Input

_MAX_VALUE = 1e9
_HEAD = "head"


class CellEdit(NamedTuple):
    """Cell of a table that the user changed, with its new value."""

    table: str
    row: int
    column: int
    value: Any


class Picked(NamedTuple):
    """Picked entity, with the clicked Point3D in the root frame."""

    entity: Any
    point: Any


class Inputs:
    """Inputs of an open dialog, by id.

    Attributes:
        written: Id of the input that the user is editing; its text is not updated.
    """

    def __init__(self, command: Any, dialog: Dialog) -> None:
        self.written = ""
        self._folder = Path(__file__).parent / dialog.folder / "resources"
        self._by_id: dict[str, Any] = {}
        self._tables: dict[str, _Table] = {}
        self._texts: dict[str, str] = {}
        self._shown: dict[str, Any] = {}
        self._command, self._dialog = command, dialog

    def create(self) -> None:
        """Create the inputs in the dialog; until then it has none, and Fusion does not show it."""
        for item in self._dialog.inputs:
            self._add(self._command.commandInputs, item)

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
            self._tables[item.id] = _Table(added, item, self._folder)
        return added

    def value(self, name: str) -> Any:
        """Return the text, number or boolean of an input, or the chosen item of a drop-down."""
        return _value(self._by_id[name])

    def set(self, name: str, value: str | float | bool) -> None:
        """Set the value of an input."""
        item = self._by_id[name]
        if isinstance(item, adsk.core.TextBoxCommandInput):
            if self._texts.get(name) != value:
                self._texts[name] = str(value)
                item.formattedText = _html(str(value))
        elif name != self.written:
            self._shown[name] = value
            if _value(item) != value:
                setattr(item, _value_name(item), value)

    def choose(self, name: str, options: Sequence[str], chosen: str) -> None:
        """Set the items of a drop-down and the chosen item."""
        self._shown[name] = chosen
        _fill(self._by_id[name].listItems, options, chosen)

    def is_own_change(self, changed: Any) -> bool:
        """Return whether the add-in, and not the user, changed an input.

        Fusion may report changes by the add-in, at once or later. An input then has the value that
        the add-in has set.
        """
        if self.written:
            return True
        if isinstance(changed, adsk.core.BoolValueCommandInput):
            return False  # each click of a button counts
        name = str(changed.id)
        if name not in self._shown:
            table, place = self._place(name)
            return table is not None and table.shows(*place, _value(changed))
        before, self._shown[name] = self._shown[name], self.value(name)
        return bool(before == self._shown[name])

    def _place(self, name: str) -> tuple[_Table | None, tuple[int, int]]:
        """Return table, row and column of an input in a table; None for other inputs."""
        table, _, place = name.partition("__")
        if not place or table not in self._tables or _HEAD in place:
            return None, (0, 0)
        _, row, column = map(int, place.split("__"))
        return self._tables[table], (row, column)

    def checked(self, name: str) -> list[str]:
        """Return the ticked items of a drop-down with check boxes."""
        items = self._by_id[name].listItems
        every = [items.item(i) for i in range(items.count)]
        return [item.name for item in every if item.isSelected]

    def check(self, name: str, options: Sequence[str], checked: Sequence[str]) -> None:
        """Set the items of a drop-down with check boxes and the ticked items."""
        items = self._by_id[name].listItems
        names = [items.item(i).name for i in range(items.count)]
        if names != list(options) or self.checked(name) != [n for n in names if n in checked]:
            items.clear()
            for option in options:
                items.add(option, option in checked)

    def picked(self, name: str) -> list[Picked]:
        """Return the entities that the user picked, and clear the selection."""
        item = self._by_id[name]
        selections = [item.selection(i) for i in range(item.selectionCount)]
        picked = [Picked(selection.entity, selection.point) for selection in selections]
        if picked:
            item.clearSelection()
        return picked

    def fill(self, name: str, rows: Sequence[Sequence[Cell]], selected: int | None = None) -> None:
        """Set the rows of a table; the selected row is unchanged if `selected` is None."""
        self._tables[name].fill(rows, selected, self.written)

    def select(self, name: str, entities: Sequence[Any]) -> None:
        """Set the entities of a selection input, which Fusion highlights."""
        item = self._by_id[name]
        item.clearSelection()
        for entity in entities:
            item.addSelection(entity)

    def selected(self, name: str) -> int:
        """Return the selected row of a table, or -1."""
        return self._tables[name].selected()

    def is_typed(self, changed: Any) -> bool:
        """Return whether a text or number is typed in an input, character by character."""
        of = ("StringValueCommandInput", "FloatSpinnerCommandInput", "IntegerSpinnerCommandInput")
        return isinstance(changed, tuple(getattr(adsk.core, name) for name in of))

    def cell(self, changed: Any) -> CellEdit | None:
        """Return the cell and value of a changed input; None if it is not in a table."""
        table, (row, column) = self._place(str(changed.id))
        if table is None or isinstance(changed, adsk.core.TextBoxCommandInput):
            return None
        if isinstance(changed, adsk.core.BoolValueCommandInput):
            return CellEdit(table.id, row, column, True)
        table.note(row, column, _value(changed))
        return CellEdit(table.id, row, column, _value(changed))


class _Table:
    """Table with a header row, whose rows are updated in place.

    Deleting a row deletes its inputs, which is not allowed while an event of one of them is
    handled.
    """

    def __init__(self, table: Any, item: Input, icons: Path) -> None:
        self._table = table
        self.id = item.id
        self._icons = icons
        self._rows: list[list[Cell]] = []
        self._made = 0
        for column, title in enumerate(item.columns):
            self._put(0, column, f"{_HEAD}__{column}", Cell(title))

    def fill(self, rows: Sequence[Sequence[Cell]], selected: int | None, written: str) -> None:
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
            self._made += 1  # ids must be unique
            for j, cell in enumerate(cells[i]):
                self._put(i + 1, j, f"{self._made}__{i}__{j}", cell)
        self._rows = cells
        row = keep + 1 if 0 <= keep < len(cells) else -1
        if self._table.selectedRow != row:
            self._table.selectedRow = row

    def _show(self, item: Any, cell: Cell) -> None:
        if cell.icon:
            item.tooltipDescription = str(cell.value)
        elif cell.options:
            _fill(item.listItems, cell.options, str(cell.value))
        elif cell.lines:
            item.formattedText = _cell_html(cell)
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
        return max(int(self._table.selectedRow) - 1, -1)

    def _put(self, row: int, column: int, place: str, cell: Cell) -> None:
        inputs, name = self._table.commandInputs, f"{self.id}__{place}"
        made: Any
        if cell.icon:
            made = inputs.addBoolValueInput(name, "", False, str(self._icons / cell.icon), False)
            made.tooltipDescription = str(cell.value)
        elif cell.lines:
            made = inputs.addTextBoxCommandInput(name, "", _cell_html(cell), cell.lines, True)
        elif cell.options:
            style = adsk.core.DropDownStyles.TextListDropDownStyle
            made = inputs.addDropDownCommandInput(name, "", style)
            _fill(made.listItems, cell.options, str(cell.value))
        elif isinstance(cell.value, int):
            made = inputs.addIntegerSpinnerCommandInput(name, "", 0, 10**6, 1, cell.value)
        else:
            made = inputs.addStringValueInput(name, "", cell.value)
            made.isReadOnly = not cell.editable
        self._table.addCommandInput(made, row, column)


def _value_name(item: Any) -> str:
    """Return the name of the property with the value of an input."""
    return "valueOne" if isinstance(item, adsk.core.FloatSliderCommandInput) else "value"


def _value(item: Any) -> Any:
    if isinstance(item, adsk.core.DropDownCommandInput):
        return item.selectedItem.name if item.selectedItem else ""
    return getattr(item, _value_name(item))


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


def _cell_html(cell: Cell) -> str:
    square = f'<font color="{cell.color}">■</font> ' if cell.color else ""
    return square + _html(str(cell.value))


def _html(text: str) -> str:
    """Return a text with escaped HTML characters, which may occur in names."""
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return text.replace("\n", "<br/>")


def _group(inputs: Any, item: Input) -> Any:
    made = inputs.addGroupCommandInput(item.id, item.label)
    made.isExpanded = not item.collapsed
    return made


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


def _number(inputs: Any, item: Input) -> Any:
    value = float(item.value or 0.0)
    return inputs.addFloatSpinnerCommandInput(item.id, item.label, "", 0.0, _MAX_VALUE, 1.0, value)


def _slider(inputs: Any, item: Input) -> Any:
    return inputs.addFloatSliderCommandInput(item.id, item.label, "", 0.0, 100.0, False)


def _check(inputs: Any, item: Input) -> Any:
    return inputs.addBoolValueInput(item.id, item.label, True, "", bool(item.value))


def _button(inputs: Any, item: Input) -> Any:
    made = inputs.addBoolValueInput(item.id, item.label, False, "", False)
    optional(lambda: setattr(made, "text", item.label))  # otherwise only the name is shown
    return made


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
    "group": _group,
    "selection": _selection,
    "dropdown": _dropdown,
    "choices": _choices,
    "string": lambda inputs, item: inputs.addStringValueInput(item.id, item.label, str(item.value)),
    "number": _number,
    "slider": _slider,
    "check": _check,
    "button": _button,
    "text": _text,
    "table": _table,
}
