"""Entry points for Fusion: `run` adds the three commands of the add-in, `stop` removes them."""

from __future__ import annotations

import contextlib
import traceback
from typing import Any

import adsk.core


def run(context: Any) -> None:
    """Add the commands to the Add-Ins panel of the Utilities tab."""
    _call_commands("start", "could not be started")


def stop(context: Any) -> None:
    """Remove everything that `run` has added."""
    _call_commands("stop", "could not be stopped cleanly")


def _call_commands(function: str, failed: str) -> None:
    """Call a function of every command, also if one of them fails."""
    try:
        # The import is inside the try block so that its failure is reported too.
        from .commands import COMMANDS, load

        for name in COMMANDS:
            try:
                getattr(load(name), function)()
            except Exception as error:
                _report(f"The command {name.replace('_', ' ')} {failed}: {error}")
    except Exception as error:
        _report(f"The add-in {failed}: {error}. Install it again: cardsflow addin install")


def _report(text: str) -> None:
    trace = traceback.format_exc()
    with contextlib.suppress(Exception):  # the message box must appear even if this fails
        adsk.core.Application.get().log(f"CARDSFlow: {trace}")
    with contextlib.suppress(Exception):  # Fusion itself does not respond
        adsk.core.Application.get().userInterface.messageBox(text, "CARDSFlow")
