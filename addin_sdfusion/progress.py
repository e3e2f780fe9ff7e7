"""Progress and cancellation of long operations."""

from __future__ import annotations

from collections.abc import Callable

from .robot.errors import CardsflowError

Progress = Callable[[int, int, str], None]
"""Function called with the number of steps done, the total (at least 1), and the next step.

It raises `Cancelled` to stop the operation, which is then undone completely.
"""


class Cancelled(CardsflowError):  # noqa: N818 - an event, not an error
    """The user stopped the operation; all files and designs are unchanged."""

    def __init__(self) -> None:
        super().__init__("cancelled; nothing was changed")


def no_progress(done: int, total: int, step: str) -> None:
    """Ignore the progress."""
