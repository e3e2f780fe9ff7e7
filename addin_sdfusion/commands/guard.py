"""Guards of event handlers: exceptions become a message for the user and a trace in the log."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import adsk.core

from ..progress import Cancelled
from ..robot.errors import CardsflowError


def application() -> Any:
    """Fusion."""
    return adsk.core.Application.get()


def message(text: str, title: str) -> None:
    """A message box with one button."""
    application().userInterface.messageBox(text, title)


def ask(text: str, title: str) -> bool:
    """Return a message box with Yes and No; whether the user says yes."""
    buttons = adsk.core.MessageBoxButtonTypes.YesNoButtonType
    icon = adsk.core.MessageBoxIconTypes.WarningIconType
    answer = application().userInterface.messageBox(text, title, buttons, icon)
    return bool(answer == adsk.core.DialogResults.DialogYes)


def chosen_file(title: str, kinds: str, save_as: str = "") -> Path | None:
    """The file that the user chooses, to be saved if it has a proposed name; None if cancelled."""
    dialog = application().userInterface.createFileDialog()
    dialog.title, dialog.filter = title, kinds
    if save_as:
        dialog.initialFilename = save_as
    answer = dialog.showSave() if save_as else dialog.showOpen()
    return Path(dialog.filename) if answer == adsk.core.DialogResults.DialogOK else None


def log(text: str) -> None:
    """A line in Fusion's log and in its Text Commands window."""
    level = adsk.core.LogLevels.ErrorLogLevel
    for kind in (adsk.core.LogTypes.FileLogType, adsk.core.LogTypes.ConsoleLogType):
        application().log(text, level, kind)


def report(error: Exception, doing: str) -> str:
    """Return the user's message for an exception; its trace goes to the log."""
    trace = "".join(traceback.format_exception(error))
    try:
        log(f"CARDSFlow: {doing}\n{trace}")
    except Exception:  # the message must come all the same
        print(trace, file=sys.stderr)
    if isinstance(error, CardsflowError):
        return str(error)
    return (
        f"{doing} did not work: {error or type(error).__name__}\n\n"
        "Check lists what is wrong with the design. If that does not help, please report it with "
        "the text of the Text Commands window (View > Show Text Commands)."
    )


def guarded(work: Callable[[Any], None], doing: str, quiet: bool = False) -> Callable[[Any], None]:
    """Return the same work, whose exceptions become a message box.

    Args:
        work: What an event's handler does with the event's arguments.
        doing: What fails, for the message: `Define muscles (OK)`.
        quiet: Whether it goes to the log alone, for events that come all the time.
    """

    def safely(args: Any) -> None:
        try:
            work(args)
        except Cancelled:
            pass
        except Exception as error:
            _show(error, doing, quiet)

    return safely


def _show(error: Exception, doing: str, quiet: bool) -> None:
    try:
        text = report(error, doing)
        if not quiet:
            message(text, "CARDSFlow")
    except Exception:  # Fusion itself does not answer
        traceback.print_exc()
