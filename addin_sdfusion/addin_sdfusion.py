"""What Fusion runs: the add-in's three commands come with `run` and go with `stop`."""

from __future__ import annotations

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
        # Within the try: what cannot be imported is told as well.
        from .commands import COMMANDS, load

        for name in COMMANDS:
            try:
                getattr(load(name), what)()
            except Exception as error:
                _tell(f"The command {name.replace('_', ' ')} {failed}: {error}")
    except Exception as error:
        _tell(f"The add-in {failed}: {error}. Install it anew: cardsflow addin install")


def _tell(text: str) -> None:
    application = adsk.core.Application.get()
    application.log(f"CARDSFlow: {traceback.format_exc()}")
    application.userInterface.messageBox(text, "CARDSFlow")
