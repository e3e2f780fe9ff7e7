"""Progress of a calibration over its stages."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from .recordings import Window


class FitProgress:
    """Counter for the work of a calibration: iterations times rows of windows.

    The total is an estimate, because the number of iterations is not known in advance. It shrinks
    when a stage ends early, and grows when a stage needs more iterations than expected. At the end
    of the last stage the completed work equals the total.

    Args:
        progress: Called with the completed work and its expected total, or None.
        iterations: Expected number of iterations of each stage.
    """

    def __init__(
        self,
        progress: Callable[[int, int], None] | None,
        stages: Sequence[Sequence[Window]],
        iterations: int,
    ) -> None:
        self._progress = progress
        self._rows = [sum(len(window.measured) for window in windows) for windows in stages]
        self._expected = iterations
        self._stage = self._iterations = self._done = 0
        self._report()

    def add_iteration(self) -> None:
        """Count an iteration of the current stage."""
        self._done += self._rows[self._stage]
        self._iterations += 1
        self._report()

    def end_stage(self) -> None:
        """Start the next stage. A stage counts as one iteration at least."""
        if not self._iterations:
            self._done += self._rows[self._stage]
        self._stage += 1
        self._iterations = 0
        self._report()

    def _report(self) -> None:
        if self._progress is None:
            return
        remaining = sum(self._expected * rows for rows in self._rows[self._stage + 1 :])
        if self._stage < len(self._rows):
            remaining += self._rows[self._stage] * max(self._expected - self._iterations, 1)
        self._progress(self._done, self._done + remaining)
