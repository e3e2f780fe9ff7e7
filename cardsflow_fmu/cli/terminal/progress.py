"""Progress of long work: a bar on a terminal, a line every 10 s elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol, TextIO

from .messages import is_quiet, print_note


class Update(Protocol):
    """Function that shows progress."""

    def __call__(self, done: int, total: int, failed: int = 0) -> None:
        """Show the number of completed units, their total (0: unknown), and the failed ones."""


PERIOD = 10.0
"""Time between two lines in a pipe or a file, in [s]."""


class ProgressLines:
    """Progress as lines, for streams that are not terminals.

    Args:
        command: The command, such as `excite`.
        unit: Name of the unit of work, in the plural.
        clock: Returns the time in [s].
    """

    def __init__(
        self, command: str, unit: str, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._command, self._unit, self._clock = command, unit, clock
        self._begin = self._last = clock()

    def update(self, done: int, total: int, failed: int = 0) -> None:
        """Print a line if the last one is `PERIOD` old."""
        now = self._clock()
        if now - self._last < PERIOD:
            return
        self._last = now
        elapsed = now - self._begin
        left = f", {_duration(elapsed * (total - done) / done)} left" if 0 < done <= total else ""
        known = f" of {total}" if total else ""
        failures = f", {failed} failed" if failed else ""
        print_note(f"{self._command}: {done}{known} {self._unit}{failures}{left}")


@contextmanager
def show_progress(command: str, unit: str) -> Iterator[Update]:
    """Provide a function that shows progress on stderr; with `--quiet` it shows nothing.

    Args:
        command: The command, such as `excite`.
        unit: Name of the unit of work, in the plural.
    """
    if is_quiet():
        yield lambda done, total, failed=0: None
    elif sys.stderr.isatty():
        from tqdm import tqdm

        with tqdm(desc=command, unit=f" {unit}", leave=False, file=_terminal()) as bar:

            def update(done: int, total: int, failed: int = 0) -> None:
                bar.total = total or None
                if failed:
                    bar.set_postfix(failed=failed, refresh=False)
                bar.update(done - bar.n)

            yield update
    else:
        yield ProgressLines(command, unit).update


def _terminal() -> TextIO:
    """Return standard error without the filter for control characters."""
    terminal: TextIO = getattr(sys.stderr, "inner", sys.stderr)
    return terminal


def _duration(seconds: float) -> str:
    """Return a duration as text, such as `1 min 20 s`."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"
