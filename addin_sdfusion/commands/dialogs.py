"""Dialogs as data, from which Fusion's inputs and the page in the docs are made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

Kind = Literal[
    "tab",
    "group",
    "selection",
    "dropdown",
    "choices",
    "string",
    "number",
    "integer",
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
        label: What the user sees beside it, or on it.
        tooltip: What it is for.
        options: Of a drop-down: what there is to choose from, where that is always the same.
        children: Of a tab or group: what it holds. Of a table: the buttons below it.
        columns: Of a table: what the columns show.
        widths: Of a table: how wide the columns are, relative to each other.
        filters: Of a selection: what may be picked.
        prompt: Of a selection: the text beside the cursor.
        rows: Of a text: how many lines are shown; of a table: the most rows shown at once.
        value: What it is at first.
        read_only: Whether a string is shown only.
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
    read_only: bool = False
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

    def all_inputs(self) -> Iterator[Input]:
        """Every input, those that hold others before what they hold."""
        yield from _below(self.inputs)


def _below(inputs: tuple[Input, ...]) -> Iterator[Input]:
    for item in inputs:
        yield item
        yield from _below(item.children)


@dataclass(frozen=True, slots=True)
class Example:
    """What a dialog may show, for the page in the docs.

    Attributes:
        values: What inputs hold, by id.
        cells: The rows of tables, by id.
        choices: Which columns of a table are drop-downs, by id.
        selected: Which row is selected, by id of a table.
        hidden: Ids of inputs that are not shown.
        icons: Of tables by id: icons in place of texts, by folder below `commands`.
    """

    values: Mapping[str, str | float | bool] = field(default_factory=dict)
    cells: Mapping[str, tuple[tuple[str, ...], ...]] = field(default_factory=dict)
    choices: Mapping[str, tuple[bool, ...]] = field(default_factory=dict)
    selected: Mapping[str, int] = field(default_factory=dict)
    hidden: tuple[str, ...] = ()
    icons: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
