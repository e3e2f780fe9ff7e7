"""Progress of long work: on a terminal only, where it can be taken back."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from cardsflow_fmu.cosim.recording import Progress
    from cardsflow_fmu.studies.run import Progress as StudyProgress


@contextmanager
def progress_bar(steps: int | None = None) -> Iterator[Progress | None]:
    """A progress bar on a terminal, nothing elsewhere.

    Args:
        steps: Number of steps; None if unknown.
    """
    if not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=steps, unit="step", leave=False, file=_terminal()) as bar:

        def show(done: int) -> None:
            bar.update(done - bar.n)

        yield show


@contextmanager
def study_progress() -> Iterator[StudyProgress | None]:
    """Runs, rate and remaining time on a terminal, nothing elsewhere."""
    if not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    with tqdm(unit="run", leave=False, smoothing=0.1, file=_terminal()) as bar:

        def show(done: int, total: int, failed: int) -> None:
            bar.total = total
            if failed:
                bar.set_postfix(failed=failed, refresh=False)
            bar.update(done - bar.n)

        yield show


def _terminal() -> TextIO:
    """Standard error, to be steered."""
    terminal: TextIO = getattr(sys.stderr, "inner", sys.stderr)
    return terminal
