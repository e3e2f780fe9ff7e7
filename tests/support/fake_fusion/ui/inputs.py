"""Inputs in the dialog of a command."""

# ruff: noqa: A002 -- the API's names

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..base import Base, api, by_name, new
from .changes import changed_by_addin


class InputData:
    """Data of one input of a dialog; the API object is a view of it."""

    def __init__(self, cls: type, id: str, name: str, command: Any, parent: Any) -> None:
        self.cls = cls
        self.id = id
        self.name = name
        self.command = command
        self.parent = parent
        self.children: list[InputData] = []
        self.gone = False
        self.table: InputData | None = None
        self.fields: dict[str, Any] = {}

    def view(self) -> Any:
        """Return the API object."""
        return new(self.cls, data=self)

    def remove(self) -> None:
        """Remove the input and its children from the dialog."""
        self.gone = True
        self.command.ids.discard(self.id)
        for child in self.children:
            child.remove()
        holder = self.parent.children if self.parent else self.command.inputs
        if self in holder:
            holder.remove(self)


def field(name: str, kind: str, default: Any, *, writable: bool = True) -> property:
    """Return a property stored in the fields of the input; `kind` is its annotation."""

    def fget(self: Any) -> Any:
        return self._data.fields.get(name, default)

    def fset(self: Any, value: Any) -> None:
        before, self._data.fields[name] = self._data.fields.get(name, default), value
        if name == "value" and value != before:
            changed_by_addin(self._data)

    fset.__annotations__["value"] = kind
    return property(fget, fset if writable else None)


@api("adsk.core")
class CommandInput(Base):
    """Base of all inputs."""

    tooltip = field("tooltip", "str", "")
    tooltipDescription = field("tooltipDescription", "str", "")
    toolClipFilename = field("toolClipFilename", "str", "")
    isEnabled = field("isEnabled", "bool", True)
    isVisible = field("isVisible", "bool", True)

    def _is_gone(self) -> bool:
        return self._data.gone or self._data.command.gone

    def __eq__(self, other: object) -> bool:
        return isinstance(other, CommandInput) and self._data is other._data

    id = property(lambda self: self._data.id)
    name = property(lambda self: self._data.name)

    @property
    def commandInputs(self) -> Any:
        """Inputs of the command, tab or group that contains this input."""
        from .command_inputs import CommandInputs

        return new(CommandInputs, command=self._data.command, parent=self._data.parent)


class _Holder(CommandInput):
    children = property(
        lambda self: by_name("CommandInputs", command=self._data.command, parent=self._data)
    )


@api("adsk.core")
class TabCommandInput(_Holder):
    resourceFolder = field("resourceFolder", "str", "", writable=False)

    isActive = property(lambda self: self._data.command.active_tab() is self._data)


@api("adsk.core")
class GroupCommandInput(_Holder):
    isExpanded = field("isExpanded", "bool", True)


@api("adsk.core")
class BoolValueCommandInput(CommandInput):
    value = field("value", "bool", False)
    isCheckBox = field("isCheckBox", "bool", True, writable=False)
    resourceFolder = field("resourceFolder", "str", "")
    text = field("text", "str", "")


@api("adsk.core")
class StringValueCommandInput(CommandInput):
    value = field("value", "str", "")
    isReadOnly = field("isReadOnly", "bool", False)


@api("adsk.core")
class TextBoxCommandInput(CommandInput):
    isReadOnly = field("isReadOnly", "bool", False)
    numRows = field("numRows", "int", 1)
    formattedText = field("text", "str", "")
    text = field("text", "str", "")


class _Ranged(CommandInput):
    def _write(self, value: float) -> None:
        if not self._data.fields["min"] <= value <= self._data.fields["max"]:
            raise RuntimeError("3 : invalid argument value: out of range")
        before, self._data.fields["value"] = self._data.fields["value"], value
        if value != before:
            changed_by_addin(self._data)


class _Spinner(_Ranged):
    value = property(lambda self: self._data.fields["value"])


@api("adsk.core")
class IntegerSpinnerCommandInput(_Spinner):
    minimumValue = field("min", "int", 0, writable=False)
    maximumValue = field("max", "int", 0, writable=False)
    spinStep = field("step", "int", 1, writable=False)

    @property
    def value(self) -> int:
        return self._data.fields["value"]

    @value.setter
    def value(self, value: int) -> None:
        self._write(value)


@api("adsk.core")
class FloatSpinnerCommandInput(_Spinner):
    """Spinner with a value in internal units."""

    minimumValue = field("min", "float", 0.0, writable=False)
    maximumValue = field("max", "float", 0.0, writable=False)
    spinStep = field("step", "float", 1.0, writable=False)
    unitType = field("unitType", "str", "", writable=False)

    @property
    def value(self) -> float:
        return self._data.fields["value"]

    @value.setter
    def value(self, value: float) -> None:
        self._write(float(value))


@api("adsk.core")
class FloatSliderCommandInput(_Ranged):
    """Slider with one handle, whose value is in internal units."""

    minimumValue = field("min", "float", 0.0, writable=False)
    maximumValue = field("max", "float", 0.0, writable=False)
    unitType = field("unitType", "str", "", writable=False)

    @property
    def valueOne(self) -> float:
        return self._data.fields["value"]

    @valueOne.setter
    def valueOne(self, value: float) -> None:
        self._write(float(value))


def below(inputs: list[InputData]) -> Iterator[InputData]:
    """Yield inputs and all inputs in them."""
    for data in inputs:
        yield data
        if data.children:
            yield from below(data.children)


def every_input(command: Any) -> list[InputData]:
    """Return all inputs of a command, including nested ones."""
    return list(below(command.inputs))
