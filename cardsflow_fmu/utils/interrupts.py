"""Handling of Ctrl-C and SIGTERM between two steps instead of in the middle of one.

A terminal that is closed sends SIGHUP, which is taken as they are, unless `nohup` has it ignored.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

INTERRUPTED = "interrupted"
"""Message of the error that Ctrl-C or SIGTERM becomes."""


@contextmanager
def interruptible() -> Iterator[list[int]]:
    """Collects the first Ctrl-C or SIGTERM instead of raising in the middle of a step.

    A second one raises KeyboardInterrupt: a single step may be endless.
    """
    pressed: list[int] = []

    def press(number: int, frame: object) -> None:
        if pressed:
            raise KeyboardInterrupt
        pressed.append(number)

    with _handling(press):
        yield pressed


@contextmanager
def terminable() -> Iterator[None]:
    """SIGTERM raises KeyboardInterrupt, as Ctrl-C does."""
    with _handling(signal.default_int_handler, _ENDS[1:]):
        yield


@contextmanager
def ignoring_interrupts() -> Iterator[None]:
    """Ctrl-C and SIGTERM do nothing meanwhile: for the seconds in which results are written."""
    with _handling(signal.SIG_IGN):
        yield


_HANG_UP = getattr(signal, "SIGHUP", None)  # Windows has none
_ENDS = [signal.SIGINT, signal.SIGTERM, *([_HANG_UP] if _HANG_UP else [])]
"""What asks a program to end."""


@contextmanager
def _handling(handler: Any, numbers: Sequence[signal.Signals] = _ENDS) -> Iterator[None]:
    """Another handler for what asks to end, in the main thread, which alone may set one."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handled = [n for n in numbers if n != _HANG_UP or signal.getsignal(n) is not signal.SIG_IGN]
    before = [signal.signal(number, handler) for number in handled]
    try:
        yield
    finally:
        for number, previous in zip(handled, before, strict=True):
            signal.signal(number, previous)
