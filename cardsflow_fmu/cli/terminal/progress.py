"""Progress of long work: a bar on a terminal, a line every 10 s elsewhere."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol, TextIO

from .messages import is_quiet, print_note

PERIOD = 10.0
"""Time between two lines in a pipe or a file, in [s]."""

_REFRESH = 0.5
_DELAY = 1.0
"""Time before a bar appears, in [s]; short work has no bar."""


class Update(Protocol):
    """Function that shows progress."""

    def __call__(self, done: int, total: int, failed: int = 0) -> None:
        """Show the number of completed units, their total (0: unknown), and the failed ones."""


class ProgressLines:
    """Progress as lines, for streams that are not terminals.

    Args:
        command: The command, such as `excite`.
        unit: Name of the unit of work, in the plural. Empty to show a percentage.
        clock: Returns the time in [s].
    """

    def __init__(
        self, command: str, unit: str = "", clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._command, self._unit, self._clock = command, unit, clock
        self._begin = self._printed = self._updated = clock()
        self._done = self._total = self._failed = 0
        self._lock = threading.Lock()

    def update(self, done: int, total: int, failed: int = 0) -> None:
        """Store the progress; print a line if the last one is `PERIOD` old."""
        with self._lock:
            self._done, self._total, self._failed = done, total, failed
            self._updated = self._clock()
        self.print_if_due()

    def print_if_due(self) -> None:
        """Print a line if the last one is `PERIOD` old."""
        with self._lock:
            now = self._clock()
            if now - self._printed < PERIOD:
                return
            self._printed = now
            print_note(f"{self._command}: {', '.join(self._parts(now))}")

    def _parts(self, now: float) -> Iterator[str]:
        done, total = self._done, self._total
        if self._unit and done:
            yield f"{done}{f' of {total}' if total else ''} {self._unit}"
        elif total:
            yield f"{done / total:.0%}"
        if self._failed:
            yield f"{self._failed} failed"
        yield f"{_duration(now - self._begin)} elapsed"
        if 0 < done < total:
            per_unit = (self._updated - self._begin) / done
            left = per_unit * (total - done) - (now - self._updated)
            if left > 0.0:
                yield f"{_duration(left)} left"


@contextmanager
def show_progress(command: str, unit: str = "") -> Iterator[Update]:
    """Provide a function that shows progress on stderr; with `--quiet` it shows nothing.

    Without a call of the function the elapsed time is shown. Arguments are as for `ProgressLines`.
    """
    if is_quiet():
        yield lambda done, total, failed=0: None
    elif sys.stderr.isatty():
        with _bar(command, unit) as update:
            yield update
    else:
        lines = ProgressLines(command, unit)
        with _call_repeatedly(lines.print_if_due):
            yield lines.update


@contextmanager
def _bar(command: str, unit: str) -> Iterator[Update]:
    """Provide a progress bar."""
    from tqdm import tqdm

    options: dict[str, Any] = {"unit": f" {unit}"} if unit else {"bar_format": "{desc}: {elapsed}"}
    terminal: TextIO = getattr(sys.stderr, "inner", sys.stderr)  # without the filter
    with tqdm(desc=command, leave=False, delay=_DELAY, file=terminal, **options) as bar:

        def update(done: int, total: int, failed: int = 0) -> None:
            if total and not unit:
                bar.bar_format = "{l_bar}{bar}| {elapsed}<{remaining}"
            bar.total = total or None
            if failed:
                bar.set_postfix(failed=failed, refresh=False)
            bar.update(done - bar.n)

        begin = time.monotonic()

        def refresh() -> None:
            if time.monotonic() - begin >= _DELAY:
                bar.refresh()

        with _call_repeatedly(refresh):
            yield update


@contextmanager
def _call_repeatedly(function: Callable[[], object]) -> Iterator[None]:
    """Call a function every `_REFRESH` in a thread, inside the context."""
    ended = threading.Event()

    def repeat() -> None:
        while not ended.wait(_REFRESH):
            function()

    thread = threading.Thread(target=repeat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def _duration(seconds: float) -> str:
    """Return a duration as text, such as `1 min 20 s`."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"
