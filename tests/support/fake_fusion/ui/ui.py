"""User interface object: message boxes, selections."""

from __future__ import annotations

from typing import Any

from ..base import Base, api, new
from ..collections_ import Items, listing
from ..maths import point
from ..state import world
from .dialogs import FileDialog, FolderDialog, ProgressDialog
from .events import Selection
from .toolbars import CommandDefinitions, ToolbarPanelList
from .ui_data import ui


@api("adsk.core")
@listing
class Selections(Items):
    """Highlighted entities."""

    def _all(self) -> list[Any]:
        return ui().selections

    def add(self, entity: Base) -> bool:
        ui().selections.append(new(Selection, entity=entity, point=point((0.0, 0.0, 0.0))))
        return True

    def clear(self) -> bool:
        ui().selections.clear()
        return True


@api("adsk.core")
class UserInterface(Base):
    def __eq__(self, other: object) -> bool:
        return isinstance(other, UserInterface)

    commandDefinitions = property(lambda _: new(CommandDefinitions))
    allToolbarPanels = property(lambda _: new(ToolbarPanelList))
    activeSelections = property(lambda _: new(Selections))

    @property
    def activeCommand(self) -> str:
        """Id of the running command, or of the selection command."""
        running = world().running
        return "SelectCommand" if running is None else running.data.definition.id

    def terminateActiveCommand(self) -> bool:
        if world().running is not None:
            world().running.terminate()
        return True

    def messageBox(self, text: str, title: str = "", buttons: int = 0, icon: int = 0) -> int:
        if buttons not in range(5) or icon not in range(5):
            raise RuntimeError("3 : invalid argument buttons or icon")
        return world().show_message(text, title, buttons, icon)

    def createProgressDialog(self) -> Any:
        return new(ProgressDialog)

    def createFolderDialog(self) -> Any:
        return new(FolderDialog)

    def createFileDialog(self) -> Any:
        return new(FileDialog)
