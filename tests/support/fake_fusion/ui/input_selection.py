"""Selection inputs."""

# ruff: noqa: A002 -- the API's names

from __future__ import annotations

from typing import Any

from ..base import Base, api, new
from ..maths import point
from ..model.filters import FILTERS, passes
from ..state import world
from .changes import changed_by_addin
from .events import Selection
from .inputs import CommandInput, field


@api("adsk.core")
class SelectionCommandInput(CommandInput):
    """Selection input; by default it accepts exactly one entity of any kind."""

    commandPrompt = field("prompt", "str", "")
    isUseCurrentSelections = field("isUseCurrentSelections", "bool", True)

    def addSelectionFilter(self, filter: str) -> bool:
        _check_filter(filter)
        self._data.fields["filters"].append(filter)
        return True

    def setSelectionLimits(self, minimum: int, maximum: int = 0) -> bool:
        if minimum < 0 or (maximum != 0 and maximum < minimum):
            raise RuntimeError("3 : invalid argument minimum or maximum")
        self._data.fields["limits"] = (minimum, maximum)
        return True

    selectionCount = property(lambda self: len(self._data.fields["selections"]))

    def selection(self, index: int) -> Any:
        chosen = self._data.fields["selections"]
        if not 0 <= index < len(chosen):
            raise RuntimeError("3 : invalid argument index")
        return chosen[index]

    def addSelection(self, selection: Base) -> bool:
        if world().why == "commandCreated":
            raise RuntimeError("3 : addSelection is not valid within commandCreated")
        _, most = self._data.fields["limits"]
        if not passes(selection, self._data.fields["filters"]):
            return False
        if most and self.selectionCount >= most:
            return False
        chosen = new(Selection, entity=selection, point=point((0.0, 0.0, 0.0)))
        self._data.fields["selections"].append(chosen)
        changed_by_addin(self._data)
        return True

    def clearSelection(self) -> bool:
        if self._data.fields["selections"]:
            self._data.fields["selections"].clear()
            changed_by_addin(self._data)
        return True

    @property
    def hasFocus(self) -> bool:
        return self._data.command.focused() is self._data

    @hasFocus.setter
    def hasFocus(self, value: bool) -> None:
        if value and not self.isVisible:
            raise RuntimeError("3 : a selection input that is not visible cannot have focus")
        if value:
            self._data.command.focus = self._data


def _check_filter(name: str) -> None:
    if name not in FILTERS:
        raise RuntimeError(f"3 : invalid argument filter {name!r}")
