"""Dialogs as data, from which Fusion's inputs and the page in the docs are made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal[
    "tab",
    "group",
    "selection",
    "dropdown",
    "choices",
    "string",
    "number",
    "check",
    "button",
    "table",
    "text",
]


@dataclass(frozen=True, slots=True)
class Input:
    """One input of a dialog.

    Attributes:
        id: Its id, unique in the dialog.
        kind: `tab` and `group` hold others; `choices` is a drop-down with check boxes; `text` is
            a box with a message; `number` has no unit.
        label: What the user sees next to it, or on it.
        tooltip: What it is for.
        options: Of a drop-down: what there is to choose from, if that is always the same.
        children: Of a tab or group: what it holds. Of a table: the buttons below it.
        columns: Of a table: what the columns show.
        widths: Of a table: how wide the columns are, relative to each other.
        filters: Of a selection: what may be picked.
        prompt: Of a selection: the text next to the cursor.
        rows: Of a text: how many lines are shown; of a table: the most rows shown at once.
        value: What it is at first.
        collapsed: Whether a group shows its name alone at first.
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
class Dialog:
    """A command's button and dialog.

    Attributes:
        id: Id of the command.
        folder: Name of the folder below `commands` with its icons in `resources`.
        name: On the button and above the dialog.
        tooltip: On the button.
        description: Below the tooltip, as the pointer rests.
        inputs: What it holds, in order.
        ok: On the button that does the work; there is none if empty.
        cancel: On the button that closes it.
        size: Width and height, in pixels.
        edits: Whether OK adds to the timeline, which takes back what was moved and not captured.
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
