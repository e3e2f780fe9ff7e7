"""The loop of a run over its steps: recording, progress, interruption, failures."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from addin_sdfusion.robot import CardsflowError, SimulationError
from cardsflow_fmu.cosim.signals.ports import SOLVE_TIME
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.interrupts import INTERRUPTED, interruptible

from .divergence import Divergence
from .pacing import Pacer
from .recording import Progress, Recording, RowSink, Watch


class StepLoop(ABC):
    """A run of a fixed number of communication steps.

    Attributes:
        names: Name of every column; the first is `time`.
        units: Unit of every column, by its name; empty for a number without one.
        count: Number of rows that a complete run gives.
    """

    names: tuple[str, ...]
    units: Mapping[str, str]
    count: int
    _recorded: int
    """Rows that are filled."""
    _report_every = 1
    """Yields of `_steps` between two looks for divergence, calls of `progress` and `watch`."""

    def run(
        self,
        progress: Progress | None = None,
        pacer: Pacer | None = None,
        watch: Watch | None = None,
        sink: RowSink | None = None,
    ) -> Recording:
        """Run to the end, to the first failure, or until Ctrl-C.

        Args:
            progress: Called now and then with the number of steps done.
            pacer: Makes steps wait for their time; None for as fast as can be.
            watch: Called as often as `progress` with the rows so far.
            sink: Memory for the rows; it is updated at every paced step, otherwise as often as
                `progress` and every 0.02 s, and closed at the end.
        """
        self._require_ready()
        rows = np.empty((self.count, len(self.names))) if sink is None else sink.rows
        self._recorded = done = checked = 0
        failure: CardsflowError | None = None
        divergence = Divergence(self.names)
        report = self._reports() if pacer is None else _by_the_clock()
        is_late = _by_the_clock()
        with interruptible() as interrupted:
            try:
                for done in self._steps(rows, pacer):
                    if interrupted:
                        raise SimulationError(INTERRUPTED)
                    is_due = report(done)
                    if is_due or pacer is not None or is_late(done):
                        checked = self._checked(rows, checked)
                        if sink is not None:
                            sink.update(checked)
                    if is_due:
                        divergence.look(rows[: self._recorded])
                        if progress:
                            progress(done)
                        if watch:
                            watch(self.names, rows[: self._recorded])
                self._checked(rows, checked)
                divergence.look(rows[: self._recorded])
            except CardsflowError as error:
                failure = self._reason(error, rows, checked)
            except KeyboardInterrupt:
                failure = self._reason(SimulationError(INTERRUPTED), rows, checked)
            if sink is not None:
                failure = self._close(sink) or failure
        if progress:
            progress(done)
        return _judged(self._recording(rows[: self._recorded], failure))

    def _reports(self) -> Callable[[int], bool]:
        every = self._report_every
        return lambda done: done % every == 0

    def _require_ready(self) -> None:  # noqa: B027 - most loops always are
        """Refuse a run that cannot be made."""

    @abstractmethod
    def _steps(self, rows: FloatArray, pacer: Pacer | None) -> Iterator[int]:
        """Step and record; yields the number of steps done."""

    @abstractmethod
    def _recording(self, rows: FloatArray, failure: CardsflowError | None) -> Recording:
        """The rows with their ticks and times."""

    def _checked(self, rows: FloatArray, first: int) -> int:
        """The number of rows, all of them checked; those before `first` are already.

        A row with what is no number is the last one.

        Raises:
            SimulationError: Something in it is no number.
        """
        k = first_not_finite(rows[first : self._recorded])
        if k is None:
            return self._recorded
        self._recorded = first + k + 1
        row = rows[first + k]
        column = int(np.flatnonzero(~np.isfinite(row))[0])
        raise SimulationError(_not_a_number(self.names[column], row[column], row[0]))

    def _reason(self, error: CardsflowError, rows: FloatArray, checked: int) -> CardsflowError:
        """Why a loop ended: what was no number in the rows before a failure led to it."""
        try:
            self._checked(rows, checked)
        except SimulationError as cause:
            same = str(cause) == str(error)
            return cause if same else SimulationError(f"{cause}; {error}")
        return error

    def _close(self, sink: RowSink) -> CardsflowError | None:
        """Pass the last rows on and close the sink; its failure, None if there is none."""
        try:
            sink.update(self._recorded)
            sink.close()
        except CardsflowError as error:
            return error
        return None


_REPORT_EVERY = 0.02
"""Time between two reports of a run that goes by the clock, in [s]."""


def _by_the_clock() -> Callable[[int], bool]:
    """Whether a report is due, of a run whose steps may take any time."""
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
    """The first row in which something is no number; None where all are finite."""
    finite = np.isfinite(rows)
    if finite.all():  # a dot product would wait for threads of BLAS
        return None
    return int((~finite.all(axis=1)).argmax())


def _judged(recording: Recording) -> Recording:
    """The recording, with a failure if a tick's time of computation is no number."""
    if recording.failure is not None or np.isfinite(recording.solve_times).all():
        return recording
    times = recording.times_of_ticks()
    k = first_not_finite(times)
    if k is None:
        return recording
    what = _not_a_number(SOLVE_TIME, times[k, 1], times[k, 0])
    return replace(recording, failure=SimulationError(what))


def _not_a_number(name: str, value: float, t: float) -> str:
    return f"{name} is {value} at t = {t:.6g} s, which is no number"
