"""Entry points for Fusion: `run` adds the add-in's three commands, `stop` removes them."""

from __future__ import annotations

import contextlib
import traceback
from typing import Any

import adsk.core


def run(context: Any) -> None:
    """Adds the commands to the Add-Ins panel of the Utilities tab."""
    _each("start", "could not be started")


def stop(context: Any) -> None:
    """Takes away everything that `run` has added."""
    _each("stop", "could not be stopped cleanly")


def _each(what: str, failed: str) -> None:
    """Starts or stops every command, also if one of them fails."""
    try:
        # Within the try: a failing import is reported as well.
        from .commands import COMMANDS, load

        for name in COMMANDS:
            try:
                getattr(load(name), what)()
            except Exception as error:
                _report(f"The command {name.replace('_', ' ')} {failed}: {error}")
    except Exception as error:
        _report(f"The add-in {failed}: {error}. Install it anew: cardsflow addin install")


def _report(text: str) -> None:
    trace = traceback.format_exc()
    with contextlib.suppress(Exception):  # the message must come all the same
        adsk.core.Application.get().log(f"CARDSFlow: {trace}")
    with contextlib.suppress(Exception):  # Fusion itself does not answer
        adsk.core.Application.get().userInterface.messageBox(text, "CARDSFlow")
