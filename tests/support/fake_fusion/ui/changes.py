"""Events of inputs that the add-in itself changes; see Options.change_events."""

from __future__ import annotations

from typing import Any

from ..base import FakeMistake
from ..state import world

_MAX_NESTED = 20


def changed_by_addin(data: Any) -> None:
    """Handle that an input has another value; only changes in an event handler are the add-in's."""
    mode, driver = world().options.change_events, world().running
    if mode == "never" or not world().why or driver is None or driver.data is not data.command:
        return
    if mode == "queued":
        driver.queue.append(data)
    elif world().why != "commandCreated":
        if world().nested > _MAX_NESTED:
            raise FakeMistake(f"events of {data.id} are nested without end")
        world().nested += 1
        try:
            driver.notify(data)
        finally:
            world().nested -= 1
