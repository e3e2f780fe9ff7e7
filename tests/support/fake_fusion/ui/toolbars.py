"""Command definitions, buttons, panels, tabs and workspaces."""

# ruff: noqa: A002 -- the API's names

from __future__ import annotations

from typing import Any

from ..base import Base, api, new, stored
from ..collections_ import Items, listing
from .command import CommandDefinition, DefinitionData
from .icons import check_icons
from .ui_data import ControlData, check_id, ui


@api("adsk.core")
@listing
class CommandDefinitions(Items):
    def _all(self) -> list[Any]:
        return [data.view() for data in ui().definitions.values()]

    def itemById(self, id: str) -> Any:
        found = ui().definitions.get(id)
        return None if found is None else found.view()

    def addButtonDefinition(
        self, id: str, name: str, tooltip: str, resourceFolder: str = ""
    ) -> Any:
        check_id(id, ui().definitions)
        check_icons(resourceFolder)
        made = DefinitionData(id, name, tooltip, resourceFolder, False)
        ui().definitions[id] = made
        return made.view()


@api("adsk.core")
class ToolbarControl(Base):
    def _is_gone(self) -> bool:
        return self._data.panel is not None and self._data not in self._data.panel.controls

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ToolbarControl) and self._data is other._data

    id = property(lambda self: self._data.definition.id)
    index = property(lambda self: self._data.panel.controls.index(self._data))

    isVisible = stored("data.visible", "bool")

    parent = property(lambda self: new(ToolbarPanel, data=self._data.panel))

    def deleteMe(self) -> bool:
        self._data.panel.controls.remove(self._data)
        return True


@api("adsk.core")
class CommandControl(ToolbarControl):
    commandDefinition = property(lambda self: self._data.definition.view())

    isPromoted = stored("data.promoted", "bool")
    isPromotedByDefault = stored("data.promoted_by_default", "bool")


@api("adsk.core")
@listing
class ToolbarControls(Items):
    def _all(self) -> list[Any]:
        return [new(CommandControl, data=data) for data in self._panel.controls]

    def itemById(self, id: str) -> Any:
        return next((c for c in self._all() if c._data.definition.id == id), None)

    def addCommand(
        self, commandDefinition: CommandDefinition, positionID: str = "", isBefore: bool = True
    ) -> Any:
        controls = self._panel.controls
        if any(c.definition is commandDefinition._data for c in controls):
            raise RuntimeError("3 : the command is in this panel already")
        places = [i for i, c in enumerate(controls) if c.definition.id == positionID]
        place = places[0] + (not isBefore) if places else len(controls)
        made = ControlData(commandDefinition._data, self._panel)
        controls.insert(place, made)
        return new(CommandControl, data=made)


@api("adsk.core")
class ToolbarPanel(Base):
    def _is_gone(self) -> bool:
        return self._data not in ui().panels

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ToolbarPanel) and self._data is other._data

    id = property(lambda self: self._data.id)
    name = property(lambda self: self._data.name)
    controls = property(lambda self: new(ToolbarControls, panel=self._data))
    isVisible = property(lambda _: True)

    def deleteMe(self) -> bool:
        if self._data.native:
            raise RuntimeError("3 : a native panel cannot be deleted")
        ui().panels.remove(self._data)
        return True


@api("adsk.core")
@listing
class ToolbarPanelList(Items):
    """All panels; add-ins cannot add panels."""

    def _all(self) -> list[Any]:
        return [new(ToolbarPanel, data=data) for data in ui().panels]

    def itemById(self, id: str) -> Any:
        return next((panel for panel in self._all() if panel.id == id), None)
