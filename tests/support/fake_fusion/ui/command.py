"""Running commands and command definitions."""

# ruff: noqa: A002 -- the API's names

from __future__ import annotations

from typing import Any

from ..base import Base, api, new, stored
from .command_inputs import CommandInputs
from .events import (
    CommandCreatedEvent,
    CommandEvent,
    InputChangedEvent,
    Listeners,
    ValidateInputsEvent,
    event,
)
from .input_selection import SelectionCommandInput
from .inputs import InputData, TabCommandInput, every_input

_EVENTS = {
    "execute": CommandEvent,
    "executePreview": CommandEvent,
    "destroy": CommandEvent,
    "inputChanged": InputChangedEvent,
    "validateInputs": ValidateInputsEvent,
}


class CommandData:
    """A running or finished command."""

    def __init__(self, definition: Any) -> None:
        self.definition = definition
        self.inputs: list[InputData] = []
        self.ids: set[str] = set()
        self.listeners = {name: Listeners() for name in _EVENTS}
        self.gone = False
        self.tab: InputData | None = None
        self.focus: InputData | None = None
        self.fields: dict[str, Any] = {
            "okButtonText": "OK",
            "cancelButtonText": "Cancel",
            "isOKButtonVisible": True,
            "isRepeatable": True,
            "isExecutedWhenPreEmpted": True,
            "helpFile": "",
        }

    def view(self) -> Any:
        """Return the API object."""
        return new(Command, data=self)

    def event(self, name: str) -> Any:
        """Return the API object of one of its events."""
        return event(_EVENTS[name], name, self.view(), self.listeners[name])

    def active_tab(self) -> InputData | None:
        """Active tab: the first one unless another was activated."""
        tabs = [data for data in self.inputs if data.cls is TabCommandInput]
        return self.tab if self.tab is not None else (tabs[0] if tabs else None)

    def focused(self) -> InputData | None:
        """Selection input that receives picked entities."""
        if self.focus is not None and not self.focus.gone:
            return self.focus
        shown = [
            data
            for data in every_input(self)
            if data.cls is SelectionCommandInput and data.fields.get("isVisible", True)
        ]
        return shown[0] if shown else None


def _event_member(name: str) -> property:
    def fget(self: Any) -> Any:
        return self._data.event(name)

    return property(fget)


def _field(name: str, kind: str) -> property:
    def fget(self: Any) -> Any:
        return self._data.fields[name]

    def fset(self: Any, value: Any) -> None:
        self._data.fields[name] = value

    fset.__annotations__["value"] = kind
    return property(fget, fset)


@api("adsk.core")
class Command(Base):
    execute = _event_member("execute")
    executePreview = _event_member("executePreview")
    destroy = _event_member("destroy")
    inputChanged = _event_member("inputChanged")
    validateInputs = _event_member("validateInputs")
    okButtonText = _field("okButtonText", "str")
    cancelButtonText = _field("cancelButtonText", "str")
    isOKButtonVisible = _field("isOKButtonVisible", "bool")
    isRepeatable = _field("isRepeatable", "bool")
    isExecutedWhenPreEmpted = _field("isExecutedWhenPreEmpted", "bool")
    helpFile = _field("helpFile", "str")

    def _is_gone(self) -> bool:
        return self._data.gone

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Command) and self._data is other._data

    commandInputs = property(lambda self: new(CommandInputs, command=self._data, parent=None))

    def setDialogInitialSize(self, width: int, height: int) -> bool:
        self._data.fields["size"] = (width, height)
        return True


class DefinitionData:
    """A command definition."""

    def __init__(self, id: str, name: str, tooltip: str, folder: str, native: bool) -> None:
        self.id, self.name, self.tooltip = id, name, tooltip
        self.folder, self.native = folder, native
        self.tool_clip = ""
        self.created = Listeners()
        self.gone = False
        self.enabled = True

    def view(self) -> Any:
        """Return the API object."""
        return new(CommandDefinition, data=self)


@api("adsk.core")
class CommandDefinition(Base):
    def _is_gone(self) -> bool:
        return self._data.gone

    def __eq__(self, other: object) -> bool:
        return isinstance(other, CommandDefinition) and self._data is other._data

    id = property(lambda self: self._data.id)

    name = stored("data.name", "str")
    tooltip = stored("data.tooltip", "str")
    toolClipFilename = stored("data.tool_clip", "str")

    @property
    def commandCreated(self) -> Any:
        return event(CommandCreatedEvent, "commandCreated", self, self._data.created)

    def execute(self) -> bool:
        from ..driver import start

        start(self._data)
        return True

    def deleteMe(self) -> bool:
        from .ui_data import ui

        if self._data.native:
            raise RuntimeError("3 : a native command definition cannot be deleted")
        self._data.gone = True
        del ui().definitions[self._data.id]
        return True
