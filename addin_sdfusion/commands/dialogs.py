"""Definitions of dialogs, from which Fusion's inputs and the help page are generated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ..robot.errors import InputError

Kind = Literal[
    "tab",
    "group",
    "selection",
    "dropdown",
    "choices",
    "string",
    "number",
    "slider",
    "check",
    "button",
    "table",
    "text",
]


@dataclass(frozen=True, slots=True)
class Input:
    """Input of a dialog.

    Attributes:
        id: Id, unique in the dialog.
        kind: Type of the input. `tab` and `group` contain inputs; `choices` is a drop-down with
            check boxes; `text` is a read-only message; `number` has no unit; `slider` is a
            percentage.
        label: Label next to or on the input.
        tooltip: Explanation of the input.
        options: Fixed items of a drop-down.
        children: Inputs in a tab or group, or buttons below a table.
        columns: Headings of the columns of a table.
        widths: Relative widths of the columns of a table.
        filters: Types of entities that a selection accepts.
        prompt: Text next to the cursor, for a selection.
        rows: Number of lines of a text, or maximum number of visible rows of a table.
        value: Initial value.
        collapsed: Whether a group is initially collapsed.
    """

    id: str
    kind: Kind
    label: str
    tooltip: str = ""
    options: tuple[str, ...] = ()
    children: tuple[Input, ...] = ()
    columns: tuple[str, ...] = ()
    widths: tuple[int, ...] = ()
    filters: tuple[str, ...] = ()
    prompt: str = ""
    rows: int = 1
    value: str | float | bool = ""
    collapsed: bool = False


@dataclass(frozen=True, slots=True)
class Cell:
    """Content of a cell of a table.

    Attributes:
        value: Text, number, or chosen item of a drop-down.
        options: Items of a drop-down.
        editable: Whether the user may edit the text.
        icon: Folder of the icon of a button, below `resources` of the command.
        lines: Number of lines of a wrapped text.
        color: Colour of a square before a wrapped text, #rrggbb; empty for no square.
    """

    value: str | int
    options: tuple[str, ...] = ()
    editable: bool = False
    icon: str = ""
    lines: int = 0
    color: str = ""

    def same_input(self, other: Cell) -> bool:
        """Return whether the same input can show the other cell."""
        properties = bool(self.options), type(self.value), self.editable, self.icon, self.lines
        return properties == (
            bool(other.options),
            type(other.value),
            other.editable,
            other.icon,
            other.lines,
        )


@dataclass(frozen=True, slots=True)
class Dialog:
    """Button and dialog of a command.

    Attributes:
        id: Id of the command.
        folder: Name of the folder below `commands` with its icons in `resources`.
        name: Name on the button and in the title of the dialog.
        tooltip: Tooltip of the button.
        description: Extended tooltip.
        inputs: Inputs, in order.
        ok: Label of the OK button; empty for a dialog without it.
        cancel: Label of the cancel button.
        size: Width and height, in pixels.
        edits: Whether OK edits the timeline, which reverts positions that are not captured.
    """

    id: str
    folder: str
    name: str
    tooltip: str
    description: str
    inputs: tuple[Input, ...]
    ok: str = "OK"
    cancel: str = "Cancel"
    size: tuple[int, int] = (440, 640)
    edits: bool = False


def number(text: str) -> float:
    """Return the number in a text, which may have a decimal comma.

    Raises:
        InputError: The text is not a number.
    """
    try:
        return float(text.strip().replace(",", "."))
    except ValueError:
        raise InputError(f"{text!r} is not a number and is ignored.") from None
