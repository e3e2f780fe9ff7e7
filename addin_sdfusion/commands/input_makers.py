"""Creation of Fusion's command inputs from the definitions of a dialog."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import adsk.core

from ..fusion.notes import optional
from .dialogs import Input
from .input_values import fill_items

_MAX_VALUE = 1e9


def _group(inputs: Any, item: Input) -> Any:
    group = inputs.addGroupCommandInput(item.id, item.label)
    group.isExpanded = not item.collapsed
    return group


def _selection(inputs: Any, item: Input) -> Any:
    selection = inputs.addSelectionInput(item.id, item.label, item.prompt)
    for name in item.filters:
        selection.addSelectionFilter(name)
    selection.setSelectionLimits(0, 0)
    if hasattr(selection, "isUseCurrentSelections"):  # since November 2024
        selection.isUseCurrentSelections = False
    return selection


def _dropdown(inputs: Any, item: Input) -> Any:
    style = adsk.core.DropDownStyles.TextListDropDownStyle
    dropdown = inputs.addDropDownCommandInput(item.id, item.label, style)
    fill_items(dropdown.listItems, item.options, str(item.value))
    return dropdown


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
    button = inputs.addBoolValueInput(item.id, item.label, False, "", False)
    optional(lambda: setattr(button, "text", item.label))  # otherwise only the name is shown
    return button


def _text(inputs: Any, item: Input) -> Any:
    return inputs.addTextBoxCommandInput(item.id, item.label, "", item.rows, True)


def _table(inputs: Any, item: Input) -> Any:
    ratio = ":".join(map(str, item.widths))
    table = inputs.addTableCommandInput(item.id, item.label, len(item.columns), ratio)
    table.minimumVisibleRows = min(3, item.rows)
    table.maximumVisibleRows = item.rows
    return table


MAKERS: dict[str, Callable[[Any, Input], Any]] = {
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
"""Function that creates an input of each kind."""
