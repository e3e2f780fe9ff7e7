"""Fusion's command inputs, created from the definition of a dialog, and their values."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import adsk.core

from .dialogs import Cell, Dialog, Input
from .input_makers import MAKERS
from .input_values import fill_items, html, input_value, value_name
from .table_input import HEAD, TableInput


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
        self._tables: dict[str, TableInput] = {}
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
        added = MAKERS[item.kind](inputs, item)
        self._by_id[item.id] = added
        if item.tooltip:
            added.tooltip = item.label or item.id
            added.tooltipDescription = item.tooltip
        for child in item.children:
            parent = inputs if item.kind == "table" else added.children
            child_input = self._add(parent, child)
            if item.kind == "table":
                added.addToolbarCommandInput(child_input)
        if item.kind == "table":
            self._tables[item.id] = TableInput(added, item, self._folder)
        return added

    def value(self, name: str) -> Any:
        """Return the text, number or boolean of an input, or the chosen item of a drop-down."""
        return input_value(self._by_id[name])

    def set(self, name: str, value: str | float | bool) -> None:
        """Set the value of an input."""
        item = self._by_id[name]
        if isinstance(item, adsk.core.TextBoxCommandInput):
            if self._texts.get(name) != value:
                self._texts[name] = str(value)
                item.formattedText = html(str(value))
        elif name != self.written:
            self._shown[name] = value
            if input_value(item) != value:
                setattr(item, value_name(item), value)

    def choose(self, name: str, options: Sequence[str], chosen: str) -> None:
        """Set the items of a drop-down and the chosen item."""
        self._shown[name] = chosen
        fill_items(self._by_id[name].listItems, options, chosen)

    def is_programmatic_change(self, changed: Any) -> bool:
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
            return table is not None and table.shows(*place, input_value(changed))
        before, self._shown[name] = self._shown[name], self.value(name)
        return bool(before == self._shown[name])

    def _place(self, name: str) -> tuple[TableInput | None, tuple[int, int]]:
        """Return table, row and column of an input in a table; None for other inputs."""
        table, _, place = name.partition("__")
        if not place or table not in self._tables or HEAD in place:
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
        table.note(row, column, input_value(changed))
        return CellEdit(table.id, row, column, input_value(changed))
