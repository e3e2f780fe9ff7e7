"""Loop over the steps of a run: recording, progress, interruption, failures."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from addin_sdfusion.robot import CardsflowError, SimulationError
from cardsflow_fmu.cosim.signals.ports import SOLVE_TIME
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.interrupts import INTERRUPTED, collect_interrupts

from .divergence import Divergence
from .pacing import Pacer
from .recording import Progress, Recording, RowSink, Watch


class StepLoop(ABC):
    """Run with a fixed number of communication steps.

    Attributes:
        names: Names of the columns; the first is `time`.
        units: Units of the columns, by name; empty for a number without a unit.
        count: Number of rows of a complete run.
    """

    names: tuple[str, ...]
    units: Mapping[str, str]
    count: int
    _recorded: int
    """Number of complete rows."""
    _report_every = 1
    """Iterations of `_steps` per check for divergence and call of `progress` and `watch`."""

    def run(
        self,
        progress: Progress | None = None,
        pacer: Pacer | None = None,
        watch: Watch | None = None,
        sink: RowSink | None = None,
    ) -> Recording:
        """Run until the end, the first failure, or Ctrl-C.

        Args:
            progress: Called regularly with the number of completed steps.
            pacer: Timer of a real-time run; None to run as fast as possible.
            watch: Called as often as `progress`, with the rows so far.
            sink: Memory for the rows. It is updated after each step in real time, otherwise with
                `progress` and every 0.02 s, and closed at the end.
        """
        self._require_ready()
        rows = np.empty((self.count, len(self.names))) if sink is None else sink.rows
        self._recorded = done = checked = 0
        failure: CardsflowError | None = None
        divergence = Divergence(self.names)
        report = self._reports() if pacer is None else _timed_reports()
        is_late = _timed_reports()
        with collect_interrupts() as interrupted:
            try:
                for done in self._steps(rows, pacer):
                    if interrupted:
                        raise SimulationError(INTERRUPTED)
                    is_due = report(done)
                    if is_due or pacer is not None or is_late(done):
                        checked = self._check_rows(rows, checked)
                        if sink is not None:
                            sink.update(checked)
                    if is_due:
                        divergence.check(rows[: self._recorded])
                        if progress:
                            progress(done)
                        if watch:
                            watch(self.names, rows[: self._recorded])
                self._check_rows(rows, checked)
                divergence.check(rows[: self._recorded])
            except CardsflowError as error:
                failure = self._root_cause(error, rows, checked)
            except KeyboardInterrupt:
                failure = self._root_cause(SimulationError(INTERRUPTED), rows, checked)
            if sink is not None:
                failure = self._close(sink) or failure
        if progress:
            progress(done)
        return _with_finite_solve_times(self._recording(rows[: self._recorded], failure))

    def _reports(self) -> Callable[[int], bool]:
        every = self._report_every
        return lambda done: done % every == 0

    def _require_ready(self) -> None:  # noqa: B027 - most loops are always ready
        """Raise an error if the loop cannot run."""

    @abstractmethod
    def _steps(self, rows: FloatArray, pacer: Pacer | None) -> Iterator[int]:
        """Step and record; yield the number of completed steps."""

    @abstractmethod
    def _recording(self, rows: FloatArray, failure: CardsflowError | None) -> Recording:
        """Return the rows with their ticks and times."""

    def _check_rows(self, rows: FloatArray, first: int) -> int:
        """Check the rows from `first` on and return the number of rows.

        A row with a value that is not finite is the last row.

        Raises:
            SimulationError: A value is not finite.
        """
        k = first_not_finite(rows[first : self._recorded])
        if k is None:
            return self._recorded
        self._recorded = first + k + 1
        row = rows[first + k]
        column = int(np.flatnonzero(~np.isfinite(row))[0])
        raise SimulationError(_not_finite_message(self.names[column], row[column], row[0]))

    def _root_cause(self, error: CardsflowError, rows: FloatArray, checked: int) -> CardsflowError:
        """Return the error that ended the loop, preceded by a value that is not finite.

        A value that is not finite often causes another error later.
        """
        try:
            self._check_rows(rows, checked)
        except SimulationError as cause:
            same = str(cause) == str(error)
            return cause if same else SimulationError(f"{cause}; {error}")
        return error

    def _close(self, sink: RowSink) -> CardsflowError | None:
        """Store the last rows and close the sink; return its failure, or None."""
        try:
            sink.update(self._recorded)
            sink.close()
        except CardsflowError as error:
            return error
        return None


_REPORT_EVERY = 0.02
"""Time between two reports, in [s]."""


def _timed_reports() -> Callable[[int], bool]:
    """Return a function that returns whether a report is due, independent of the step duration."""
    due = 0.0

    def report(done: int) -> bool:
        nonlocal due
        now = time.monotonic()
        if now < due:
            return False
        due = now + _REPORT_EVERY
        return True

    return report


def first_not_finite(rows: FloatArray) -> int | None:
    """Return the index of the first row with a value that is not finite, or None."""
    finite = np.isfinite(rows)
    if finite.all():  # faster than a dot product, which would wait for BLAS threads
        return None
    return int((~finite.all(axis=1)).argmax())


def _with_finite_solve_times(recording: Recording) -> Recording:
    """Return the recording, with a failure if a tick's computation time is not finite."""
    if recording.failure is not None or np.isfinite(recording.solve_times).all():
        return recording
    times = recording.times_of_ticks()
    k = first_not_finite(times)
    if k is None:
        return recording
    what = _not_finite_message(SOLVE_TIME, times[k, 1], times[k, 0])
    return replace(recording, failure=SimulationError(what))


def _not_finite_message(name: str, value: float, t: float) -> str:
    return f"{name} is not finite at t = {t:.6g} s: {value}"
