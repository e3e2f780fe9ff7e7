"""Values of Fusion's command inputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import adsk.core

from .dialogs import Cell


def value_name(item: Any) -> str:
    """Return the name of the property with the value of an input."""
    return "valueOne" if isinstance(item, adsk.core.FloatSliderCommandInput) else "value"


def input_value(item: Any) -> Any:
    """Return the value of an input, or the chosen item of a drop-down."""
    if isinstance(item, adsk.core.DropDownCommandInput):
        return item.selectedItem.name if item.selectedItem else ""
    return getattr(item, value_name(item))


def fill_items(items: Any, options: Sequence[str], chosen: str) -> None:
    """Set the items of a drop-down and the chosen item."""
    names = [items.item(i).name for i in range(items.count)]
    if names != list(options):
        items.clear()
        for option in options:
            items.add(option, option == chosen)
        return
    for i, option in enumerate(options):
        if option == chosen and not items.item(i).isSelected:
            items.item(i).isSelected = True


def cell_html(cell: Cell) -> str:
    """Return the text of a cell with wrapped text."""
    square = f'<font color="{cell.color}">■</font> ' if cell.color else ""
    return square + html(str(cell.value))


def html(text: str) -> str:
    """Return a text with escaped HTML characters, which may occur in names."""
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return text.replace("\n", "<br/>")
