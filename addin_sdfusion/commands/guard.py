"""Guards of event handlers, which show exceptions to the user and log their tracebacks."""

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
    """Return the application object of Fusion."""
    return adsk.core.Application.get()


def message(text: str, title: str) -> None:
    """Show a message box with one button."""
    application().userInterface.messageBox(text, title)


def ask(text: str, title: str) -> bool:
    """Show a message box with Yes and No, and return whether the user pressed Yes."""
    buttons = adsk.core.MessageBoxButtonTypes.YesNoButtonType
    icon = adsk.core.MessageBoxIconTypes.WarningIconType
    answer = application().userInterface.messageBox(text, title, buttons, icon)
    return bool(answer == adsk.core.DialogResults.DialogYes)


def chosen_file(title: str, kinds: str, save_as: str = "") -> Path | None:
    """Return a file chosen by the user, or None if cancelled.

    Args:
        kinds: File types.
        save_as: Proposed name of a file to save; empty for a file to open.
    """
    dialog = application().userInterface.createFileDialog()
    dialog.title, dialog.filter = title, kinds
    if save_as:
        dialog.initialFilename = save_as
    answer = dialog.showSave() if save_as else dialog.showOpen()
    return Path(dialog.filename) if answer == adsk.core.DialogResults.DialogOK else None


def log(text: str) -> None:
    """Write a line to Fusion's log and its Text Commands window."""
    level = adsk.core.LogLevels.ErrorLogLevel
    for kind in (adsk.core.LogTypes.FileLogType, adsk.core.LogTypes.ConsoleLogType):
        application().log(text, level, kind)


def report(error: Exception, doing: str) -> str:
    """Return the message for the user on an exception, and log its traceback."""
    trace = "".join(traceback.format_exception(error))
    try:
        log(f"CARDSFlow: {doing}\n{trace}")
    except Exception:  # the user must see the message even if logging fails
        print(trace, file=sys.stderr)
    if isinstance(error, CardsflowError):
        return str(error)
    return (
        f"{doing} failed: {error or type(error).__name__}\n\n"
        "Check lists the problems of the design. If this does not help, please report it with "
        "the text of the Text Commands window (View > Show Text Commands)."
    )


def guard_handler(
    work: Callable[[Any], None], doing: str, quiet: bool = False
) -> Callable[[Any], None]:
    """Return an event handler whose exceptions are shown in a message box.

    Args:
        work: Handler that is called with the arguments of the event.
        doing: Name of the action for the message, such as `Define muscles (OK)`.
        quiet: Whether exceptions are only logged, for frequent events.
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
    except Exception:  # Fusion itself does not respond
        traceback.print_exc()
