"""Control of the running fake by tests: messages shown to the user, actions of the user."""

# ruff: noqa: A002 -- the API's names

from __future__ import annotations

from typing import Any

from .app import Application
from .designer import Designer
from .driver import Driver, start
from .model.fingerprint import fingerprint
from .state import Options, World, roll_back, world
from .ui.ui_data import ui


class Fake:
    """Controller of the running Fusion, with the records of World such as messages and log."""

    @property
    def world(self) -> World:
        """State of the running Fusion."""
        return world()

    @property
    def app(self) -> Application:
        """API object of the application."""
        return Application.get()

    @property
    def design(self) -> Any:
        """Active design, or None."""
        return self.app.activeProduct

    @property
    def options(self) -> Options:
        """Unknown properties of Fusion, which tests change to check that they do not matter."""
        return world().options

    @property
    def messages(self) -> list[str]:
        """Texts of all message boxes."""
        return world().messages

    @property
    def log(self) -> list[str]:
        """All logged texts."""
        return [text for text, _, _ in world().log]

    def fingerprint(self) -> str:
        """Return a text that depends on all data of the user in the active design."""
        return fingerprint(world().active)

    def full_fingerprint(self) -> str:
        """Return a text that depends on all data in the active design, including the add-in's."""
        return fingerprint(world().active, everything=True)

    def undo(self) -> None:
        """Undo the last step."""
        roll_back(world().undo_steps.pop())

    def without(self, *members: str) -> None:
        """Remove members, such as `Design.designIntent`, to simulate an older version."""
        world().missing.update(members)

    @property
    def designer(self) -> Designer:
        """User who edits the active design; each action is one undo step."""
        return Designer(world().active)

    def run_command(self, id: str) -> Driver:
        """Press the button of a command of the add-in; see `driver`."""
        return start(ui().definitions[id])

    def buttons(self, panel: str = "SolidScriptsAddinsPanel") -> list[str]:
        """Return the ids of the commands in a panel."""
        return [control.definition.id for control in ui().panel(panel).controls]

    def activate(self, design: Any) -> None:
        """Switch to the document of a design."""
        world().active = design._data

    def building(self) -> Any:
        """Return a context for edits of the user before the test."""
        return world().building()

    def transaction(self) -> Any:
        """Return a context of one undo step, like execute."""
        return world().transaction()
