"""Control of the running fake by tests: reads what the user was shown, plays the user."""

# ruff: noqa: A002 -- the API's names

from __future__ import annotations

from typing import Any

from .app import Application
from .driver import Driver, start
from .model.fingerprint import fingerprint
from .state import Options, World, roll_back, world
from .ui.ui_data import ui


class Fake:
    """The Fusion that runs. Everything that World records is here too: messages, log, ..."""

    @property
    def world(self) -> World:
        """The state."""
        return world()

    @property
    def app(self) -> Application:
        """The API's application."""
        return Application.get()

    @property
    def design(self) -> Any:
        """The active design, or None."""
        return self.app.activeProduct

    @property
    def options(self) -> Options:
        """What is unknown about Fusion: change it to test that it does not matter."""
        return world().options

    @property
    def messages(self) -> list[str]:
        """Texts of the message boxes so far."""
        return world().messages

    @property
    def log(self) -> list[str]:
        """Texts logged so far."""
        return [text for text, _, _ in world().log]

    def fingerprint(self) -> str:
        """A text that changes with anything of the user's in the active design."""
        return fingerprint(world().active)

    def full_fingerprint(self) -> str:
        """A text that changes with anything in the active design, the add-in's points included."""
        return fingerprint(world().active, everything=True)

    def undo(self) -> None:
        """Undo the last step, as the user would."""
        roll_back(world().undo_steps.pop())

    def without(self, *members: str) -> None:
        """Take members, such as `Design.designIntent`, away: an older version of Fusion."""
        world().missing.update(members)

    def run_command(self, id: str) -> Driver:
        """Press the button of a command that the add-in has added: see `driver`."""
        return start(ui().definitions[id])

    def buttons(self, panel: str = "SolidScriptsAddinsPanel") -> list[str]:
        """Ids of the commands in a panel."""
        return [control.definition.id for control in ui().panel(panel).controls]

    def activate(self, design: Any) -> None:
        """Switch to the document of a design."""
        world().active = design._data

    def building(self) -> Any:
        """A context in which the test edits the model through the API, as the user did before."""
        return world().building()

    def transaction(self) -> Any:
        """A context of one undo step, as execute is."""
        return world().transaction()
