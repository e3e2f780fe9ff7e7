"""Data of the user interface: buttons, panels, tabs."""

# ruff: noqa: A002 -- the API's names

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

from ..state import world
from .command import DefinitionData

_ID = re.compile(r"[A-Za-z0-9_]+")
_NATIVE_PANELS = ("SolidCreatePanel", "InspectPanel", "SolidScriptsAddinsPanel")


@dataclass(eq=False)
class ControlData:
    """A button in a panel."""

    definition: DefinitionData
    panel: Any
    promoted: bool = False
    promoted_by_default: bool = False
    visible: bool = True


@dataclass(eq=False)
class PanelData:
    """A panel of a tab."""

    id: str
    name: str
    native: bool = False
    controls: list[ControlData] = field(default_factory=list)


class UiData:
    """State of the user interface."""

    def __init__(self) -> None:
        self.definitions: dict[str, DefinitionData] = {}
        native = DefinitionData("ScriptsManagerCommand", "Scripts and Add-Ins", "", "", True)
        self.definitions[native.id] = native
        self.panels = [PanelData(name, name, native=True) for name in _NATIVE_PANELS]
        self.panel("SolidScriptsAddinsPanel").controls.append(ControlData(native, None))
        self.selections: list[Any] = []

    def panel(self, id: str) -> Any:
        """Return the panel with an id, or None."""
        return next((panel for panel in self.panels if panel.id == id), None)


def ui() -> UiData:
    """Return the user interface of the running Fusion."""
    if world().ui is None:
        world().ui = UiData()
    return world().ui


def check_id(id: str, taken: Any) -> None:
    if not _ID.fullmatch(id) or id in taken:
        raise RuntimeError(f"3 : invalid argument id {id!r}: taken, or not of A-Z a-z 0-9 _")
