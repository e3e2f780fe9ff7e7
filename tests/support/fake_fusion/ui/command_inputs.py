"""Inputs that an add-in adds to its dialog."""

# ruff: noqa: A002 -- the API's names

from __future__ import annotations

from typing import Any

from ..base import api
from ..collections_ import Items, listing
from .icons import check_icons
from .input_lists import DropDownCommandInput
from .input_selection import SelectionCommandInput
from .input_table import TableCommandInput
from .inputs import (
    BoolValueCommandInput,
    FloatSliderCommandInput,
    FloatSpinnerCommandInput,
    GroupCommandInput,
    InputData,
    IntegerSpinnerCommandInput,
    StringValueCommandInput,
    TabCommandInput,
    TextBoxCommandInput,
    below,
)


@api("adsk.core")
@listing
class CommandInputs(Items):
    """Inputs of a command, or of one of its tabs or groups."""

    def _is_gone(self) -> bool:
        return self._command.gone or (self._parent is not None and self._parent.gone)

    @property
    def _shelf(self) -> list[InputData]:
        return self._command.inputs if self._parent is None else self._parent.children

    def _all(self) -> list[Any]:
        return [data.view() for data in self._shelf]

    def __eq__(self, other: object) -> bool:
        same = isinstance(other, CommandInputs) and self._command is other._command
        return same and self._parent is other._parent

    command = property(lambda self: self._command.view())

    def itemById(self, id: str) -> Any:
        """Return an input by id, anywhere in the dialog or in the tab or group."""
        found = next((data for data in below(self._shelf) if data.id == id), None)
        return None if found is None else found.view()

    def _add(self, cls: type, id: str, name: str, **fields: Any) -> Any:
        ids = self._command.ids
        if not id or id in ids:
            raise RuntimeError(f"3 : invalid argument id {id!r}: it is empty or taken")
        data = InputData(cls, id, name, self._command, self._parent)
        ids.add(id)
        data.fields.update(fields)
        self._shelf.append(data)
        return data.view()

    def addTabCommandInput(self, id: str, name: str, resourceFolder: str = "") -> Any:
        if self._parent is not None:
            raise RuntimeError("3 : tabs cannot be within tabs or groups")
        return self._add(TabCommandInput, id, name, resourceFolder=resourceFolder)

    def addGroupCommandInput(self, id: str, name: str) -> Any:
        if self._parent is not None and self._parent.cls is GroupCommandInput:
            raise RuntimeError("3 : groups cannot be within groups")
        return self._add(GroupCommandInput, id, name)

    def addBoolValueInput(
        self,
        id: str,
        name: str,
        isCheckBox: bool,
        resourceFolder: str = "",
        initialValue: bool = False,
    ) -> Any:
        check_icons(resourceFolder)
        return self._add(
            BoolValueCommandInput,
            id,
            name,
            isCheckBox=isCheckBox,
            resourceFolder=resourceFolder,
            value=initialValue,
        )

    def addStringValueInput(self, id: str, name: str, initialValue: str = "") -> Any:
        return self._add(StringValueCommandInput, id, name, value=initialValue)

    def addTextBoxCommandInput(
        self, id: str, name: str, formattedText: str, numRows: int, isReadOnly: bool
    ) -> Any:
        if numRows < 1:
            raise RuntimeError("3 : invalid argument numRows")
        return self._add(
            TextBoxCommandInput,
            id,
            name,
            text=formattedText,
            numRows=numRows,
            isReadOnly=isReadOnly,
        )

    def addIntegerSpinnerCommandInput(
        self, id: str, name: str, min: int, max: int, spinStep: int, initialValue: int
    ) -> Any:
        if not (min <= initialValue <= max and spinStep > 0):
            raise RuntimeError("3 : invalid argument min, max, spinStep or initialValue")
        return self._add(
            IntegerSpinnerCommandInput,
            id,
            name,
            min=min,
            max=max,
            step=spinStep,
            value=initialValue,
        )

    def addFloatSpinnerCommandInput(
        self,
        id: str,
        name: str,
        unitType: str,
        min: float,
        max: float,
        spinStep: float,
        initialValue: float,
    ) -> Any:
        if not (min <= initialValue <= max and spinStep > 0.0):
            raise RuntimeError("3 : invalid argument min, max, spinStep or initialValue")
        return self._add(
            FloatSpinnerCommandInput,
            id,
            name,
            unitType=unitType,
            min=float(min),
            max=float(max),
            step=float(spinStep),
            value=float(initialValue),
        )

    def addFloatSliderCommandInput(
        self,
        id: str,
        name: str,
        unitType: str,
        min: float,
        max: float,
        hasTwoSliders: bool = False,
    ) -> Any:
        if not min < max or hasTwoSliders:
            raise RuntimeError("3 : invalid argument min, max or hasTwoSliders")
        cls, lower, upper = FloatSliderCommandInput, float(min), float(max)
        return self._add(cls, id, name, unitType=unitType, min=lower, max=upper, value=lower)

    def addSelectionInput(self, id: str, name: str, commandPrompt: str) -> Any:
        return self._add(
            SelectionCommandInput,
            id,
            name,
            prompt=commandPrompt,
            filters=[],
            limits=(1, 1),
            selections=[],
        )

    def addDropDownCommandInput(self, id: str, name: str, dropDownStyle: int) -> Any:
        if dropDownStyle not in (0, 1, 2):
            raise RuntimeError("3 : invalid argument dropDownStyle")
        return self._add(
            DropDownCommandInput, id, name, style=dropDownStyle, items=[], many=dropDownStyle == 2
        )

    def addTableCommandInput(
        self, id: str, name: str, numberOfColumns: int, columnRatio: str
    ) -> Any:
        if not all(part.isdigit() for part in columnRatio.split(":")):
            raise RuntimeError("3 : invalid argument columnRatio")
        return self._add(TableCommandInput, id, name, columnRatio=columnRatio, cells={}, toolbar=[])
