"""Simulated user of a command, who presses its button, picks, types, and presses OK or Cancel.

    command = fake.run_command("defineMuscles")
    command.pick("points", vertex)          # rejected if a filter does not accept it
    command.set("muscle", "biceps")         # text, number, boolean, item of a drop-down, items
    command.press("add")                    # a button
    command.row("table", 2)
    command.cell("table", 1, 0)             # the input in a cell; set(id, ...) changes it
    command.ok()                            # or cancel()

After each action of the user Fusion fires inputChanged, validateInputs and, if the inputs are
valid, executePreview. The edits of executePreview are undone before the next event.
"""

# ruff: noqa: A002, N818 -- the API's names

from __future__ import annotations

from pathlib import Path
from typing import Any

from .base import FakeMistake, new
from .maths import point
from .model.entity import current
from .state import roll_back, world
from .ui.command import CommandData, DefinitionData
from .ui.events import (
    CommandCreatedEventArgs,
    CommandEventArgs,
    InputChangedEventArgs,
    Selection,
    ValidateInputsEventArgs,
    event,
    fire,
)
from .ui.input_lists import select_item
from .ui.input_selection import SelectionCommandInput
from .ui.inputs import (
    BoolValueCommandInput,
    FloatSliderCommandInput,
    InputData,
    TextBoxCommandInput,
    every_input,
)
from .ui.picking import why_not

_MAX_QUEUE = 1000


class Rejected(Exception):
    """The user cannot do this: pick an entity rejected by a filter, press a disabled button."""


def start(definition: DefinitionData) -> Driver:
    """Run a command like its button; a running command is terminated first."""
    if world().running is not None:
        world().running.preempt()
    if definition.native:
        raise FakeMistake(f"{definition.id} is Fusion's own")
    if not definition.enabled:
        raise Rejected(f"the button of {definition.id} is disabled")
    driver = Driver(CommandData(definition))
    world().running = driver
    driver.open()
    return driver


def running(data: CommandData) -> Driver:
    """Return the driver of a running command."""
    assert world().running is not None
    assert world().running.data is data
    return world().running


class Driver:
    """Driver of a running command.

    Attributes:
        data: The command.
        is_open: Whether its dialog is open.
        failed: Message of a failed execute, or empty.
        clicks: Number of clicks of the user, including the click on the button of the command. An
            item of a drop-down requires two clicks, a typed text one.
        queue: Inputs that the add-in changed and whose events are not sent yet.
    """

    def __init__(self, data: CommandData) -> None:
        self.data = data
        self.is_open = True
        self.failed = ""
        self.clicks = 1
        self.queue: list[InputData] = []
        self._steps: list[Any] = []

    # Actions of the user ------------------------------------------------------------------------

    def pick(self, id: str, entity: Any, at: Any = None, *, through: bool = False) -> None:
        """Click an entity while a selection input has the focus.

        Args:
            id: The selection input.
            entity: The entity, in the context of the root.
            at: The clicked point.
            through: Press long, which also selects entities inside bodies.

        Raises:
            Rejected: The filters of the input reject the entity, the input is invisible, or the
                entity is hidden or inside a body.
        """
        self.clicks += 1
        data, entity = self._input(id), current(entity)
        self._must_be(data, SelectionCommandInput)
        self._must_be_usable(data)
        if problem := why_not(entity, data, through):
            raise Rejected(f"{id}: {problem}")
        self.data.focus = data
        chosen = new(Selection, entity=entity, point=point((0.0, 0.0, 0.0)) if at is None else at)
        _, most = data.fields["limits"]
        selections = data.fields["selections"]
        if most and len(selections) >= most:
            selections.pop()
        selections.append(chosen)
        self._changed(data)

    def set(self, id: str, value: Any) -> None:
        """Type a value, choose an item by name, tick a box.

        Args:
            id: The input.
            value: Text, number or boolean; name of the item; names of all ticked items.

        Raises:
            Rejected: The input is read-only, disabled, invisible, or has no such item.
        """
        data = self._input(id)
        self._must_be_usable(data)
        self.clicks += 2 if "items" in data.fields else 1
        view = data.view()
        if "items" in data.fields:
            self._choose(data, value)
        elif isinstance(view, TextBoxCommandInput):
            view.text = value
        elif isinstance(view, FloatSliderCommandInput):
            view.valueOne = value
        else:
            view.value = value
        self._changed(data)

    def press(self, id: str) -> None:
        """Click a button."""
        self.clicks += 1
        data = self._input(id)
        self._must_be(data, BoolValueCommandInput)
        self._must_be_usable(data)
        data.fields["value"] = not data.fields["value"]
        self._changed(data)

    def row(self, id: str, row: int) -> None:
        """Click a row of a table; -1 clicks outside the rows."""
        self.clicks += 1
        self._input(id).view().selectedRow = row

    def tab(self, id: str) -> None:
        """Open a tab; the event is sent first for this tab and then for the previous one."""
        self.clicks += 1
        left, self.data.tab = self.data.active_tab(), self._input(id)
        self._changed(self.data.tab)
        if left is not None and left is not self.data.tab:
            self._changed(left)

    def ok(self) -> None:
        """Press OK.

        Raises:
            Rejected: The button is disabled or does not exist.
        """
        self._must_be_open()
        self.clicks += 1
        if not self.data.fields["isOKButtonVisible"]:
            raise Rejected("there is no OK button")
        if not self.is_valid():
            raise Rejected("the OK button is disabled")
        self._execute()
        self._close()

    def cancel(self) -> None:
        """Press Cancel."""
        self._must_be_open()
        self._close()

    # State for tests ----------------------------------------------------------------------

    def __getitem__(self, id: str) -> Any:
        """Return the API input with an id."""
        return self._input(id).view()

    def ids(self) -> list[str]:
        """Return the ids of all inputs."""
        return [data.id for data in every_input(self.data)]

    def items(self, id: str) -> list[str]:
        """Return the names of the items of a drop-down."""
        return [item.name for item in self._input(id).fields["items"]]

    def chosen(self, id: str) -> list[str]:
        """Return the names of the chosen items of a drop-down."""
        return [item.name for item in self._input(id).fields["items"] if item.selected]

    def cell(self, id: str, row: int, column: int) -> Any:
        """Return the API input in a cell of a table, or None."""
        return self[id].getInputAtPosition(row, column)

    def table(self, id: str) -> list[list[Any]]:
        """Return the rows of a table: value, chosen item or icon name of every cell."""
        view = self[id]
        columns = range(view.numberOfColumns)
        return [
            [_shown(view.getInputAtPosition(r, c)) for c in columns] for r in range(view.rowCount)
        ]

    def is_valid(self) -> bool:
        """Return whether OK is enabled."""
        for data in every_input(self.data):
            if data.cls is SelectionCommandInput and data.fields.get("isVisible", True):
                least, _ = data.fields["limits"]
                if len(data.fields["selections"]) < least:
                    return False
        firing = self.data.event("validateInputs")
        args = fire(firing, ValidateInputsEventArgs, command=self.data.view())
        return bool(args._areInputsValid)

    # Actions of Fusion --------------------------------------------------------------------------

    def open(self) -> None:
        """Let the add-in create the dialog; a command without inputs is executed directly."""
        definition = self.data.definition
        firing = event(
            type(definition.view().commandCreated),
            "commandCreated",
            definition.view(),
            definition.created,
        )
        try:
            fire(firing, CommandCreatedEventArgs, command=self.data.view())
            if not self.is_open:  # terminated while the add-in processed events
                return
            if self.data.inputs:
                self._send_queue()
                self.preview()
                return
        except BaseException:
            self._abort()
            raise
        self._execute()
        self._close()

    def preview(self) -> None:
        """Undo the last preview and fire executePreview if the inputs are valid."""
        self._undo_preview()
        if not self.is_open or not self.is_valid():
            return
        outer, world().journal = world().journal, []
        try:
            self._fire("executePreview")
        finally:
            self._steps, world().journal = world().journal or [], outer

    def preempt(self) -> None:
        """Start another command."""
        if self.data.fields["isExecutedWhenPreEmpted"] and self.is_valid():
            self._execute()
        self._close()

    def terminate(self) -> None:
        """Terminate the command by another part of the program."""
        self._close()

    def _execute(self) -> None:
        self._undo_preview()
        args: list[Any] = []
        with world().transaction(keep=lambda: not args[0]._executeFailed):
            args.append(self._fire("execute"))
        if args[0]._executeFailed:
            self.failed = args[0]._executeFailedMessage or "failed"
            world().show_message(self.failed)

    def _undo_preview(self) -> None:
        roll_back(self._steps)
        self._steps = []

    def _close(self) -> None:
        if not self.is_open:
            return
        self._undo_preview()
        self.is_open = False
        if world().running is self:
            world().running = None
        try:
            self._fire("destroy")
        finally:
            self.data.gone = True

    def _abort(self) -> None:
        self._undo_preview()
        self.is_open, self.data.gone = False, True
        world().running = None

    def _fire(self, name: str) -> Any:
        return fire(self.data.event(name), CommandEventArgs, command=self.data.view())

    def _changed(self, data: InputData) -> None:
        self._undo_preview()
        self.notify(data)
        self._send_queue()
        if self.is_open:
            self.preview()

    def notify(self, data: InputData) -> None:
        """Fire inputChanged."""
        outer, world().changing = world().changing, data
        try:
            fire(self.data.event("inputChanged"), InputChangedEventArgs, input=data.view())
        finally:
            world().changing = outer

    def _send_queue(self) -> None:
        for _ in range(_MAX_QUEUE):
            if not self.queue or not self.is_open:
                return
            data = self.queue.pop(0)
            if not data.gone:
                self.notify(data)
        raise FakeMistake(f"changes of {self.queue[0].id} cause events without end")

    # Checks ------------------------------------------------------------------------------------

    def _must_be_open(self) -> None:
        if not self.is_open:
            raise Rejected("the dialog is closed")

    def _input(self, id: str) -> InputData:
        self._must_be_open()
        found = [data for data in every_input(self.data) if data.id == id]
        if not found:
            raise KeyError(f"no input {id!r} among {', '.join(self.ids())}")
        return found[0]

    def _must_be(self, data: InputData, cls: type) -> None:
        if data.cls is not cls:
            raise FakeMistake(f"{data.id} is a {data.cls.__name__}, not a {cls.__name__}")

    def _must_be_usable(self, data: InputData) -> None:
        holder: InputData | None = data
        while holder is not None:
            shown = holder.fields.get("isVisible", True)
            if not shown or not holder.fields.get("isEnabled", True):
                raise Rejected(f"{data.id}: it is disabled or not visible")
            holder = holder.parent
        if data.fields.get("isReadOnly"):
            raise Rejected(f"{data.id}: it is read-only")

    def _choose(self, data: InputData, value: Any) -> None:
        items = data.fields["items"]
        expected = [value] if isinstance(value, str) else list(value)
        unknown = set(expected) - {item.name for item in items}
        if unknown:
            raise Rejected(f"{data.id}: no item {unknown} among {[i.name for i in items]}")
        if data.fields["many"]:
            for item in items:
                item.selected = item.name in expected
            return
        select_item(data, next(item for item in items if item.name == expected[0]), True)


def _shown(view: Any) -> Any:
    if view is None:
        return None
    if "items" in view._data.fields:
        return view.selectedItem.name if view.selectedItem else ""
    folder = view._data.fields.get("resourceFolder")
    if folder:
        return Path(folder).name
    return view._data.fields.get("value", view._data.fields.get("text"))
