"""Handling of Ctrl-C and SIGTERM between two steps instead of within a step.

A closed terminal sends SIGHUP, which is handled in the same way, unless `nohup` ignores it.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

INTERRUPTED = "interrupted"
"""Message of the error that Ctrl-C or SIGTERM causes."""


@contextmanager
def collect_interrupts() -> Iterator[list[int]]:
    """Collect the first Ctrl-C or SIGTERM instead of raising an exception within a step.

    A second signal raises KeyboardInterrupt, since a step may never end.
    """
    received: list[int] = []

    def collect(number: int, frame: object) -> None:
        if received:
            raise KeyboardInterrupt
        received.append(number)

    with _signal_handler(collect):
        yield received


@contextmanager
def raise_on_termination() -> Iterator[list[int]]:
    """Raise KeyboardInterrupt on Ctrl-C and SIGTERM; yield the list of received signals.

    Libraries can replace the exception by another one, for example if they import a module.
    """
    received: list[int] = []

    def interrupt(number: int, frame: object) -> None:
        received.append(number)
        raise KeyboardInterrupt

    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN  # a job in the background
    with _signal_handler(interrupt, _SIGNALS[1:] if ignored else _SIGNALS):
        yield received


@contextmanager
def ignore_interrupts() -> Iterator[None]:
    """Ignore Ctrl-C and SIGTERM, for example while results are written."""
    with _signal_handler(signal.SIG_IGN):
        yield


_HANG_UP = getattr(signal, "SIGHUP", None)  # does not exist on Windows
_SIGNALS = [signal.SIGINT, signal.SIGTERM, *([_HANG_UP] if _HANG_UP else [])]
"""Signals that request the end of a program."""


@contextmanager
def _signal_handler(handler: Any, numbers: Sequence[signal.Signals] = _SIGNALS) -> Iterator[None]:
    """Set another handler for signals; only possible in the main thread, otherwise do nothing."""
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
