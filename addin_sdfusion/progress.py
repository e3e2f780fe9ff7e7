"""Progress and cancelling of long work."""

from __future__ import annotations

from collections.abc import Callable

from .robot.errors import CardsflowError

Progress = Callable[[int, int, str], None]
"""Called with what is done, the whole, which is at least 1, and what comes next.

To stop the work it raises `Cancelled`; nothing is left half done then.
"""


class Cancelled(CardsflowError):  # noqa: N818 - what happened, not what is wrong
    """The user has stopped the work; what was there before is as it was."""

    def __init__(self) -> None:
        super().__init__("cancelled; nothing was changed")


def no_progress(done: int, whole: int, what: str) -> None:
    """A `Progress` without effect."""
