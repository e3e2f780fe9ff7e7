"""Fixed-step co-simulation master for any number of participants; the steps are in C."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, SimulationError
from cardsflow_fmu.cosim.signals.ports import SOLVE_TIME
from cardsflow_fmu.cosim.signals.units import Conversion
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.interrupts import INTERRUPTED, collect_interrupts

from .coupling import Coupling
from .divergence import column_limits, not_finite_error, not_finite_message, row_error
from .pacing import Pacer
from .participant import Participant, Wired
from .recording import NumberLog, Progress, Recording, RowSink, Watch
from .stepper import Stepper, Turn, Value
from .wiring import Wiring, connect

_CHUNK = 256
"""Maximum number of steps per call of C."""
_SLICE = 0.02
"""Maximum time per call of C and between two reports, in [s], so that Ctrl-C takes effect."""


class Master:
    """Master that steps connected participants.

    A participant that is stepped every k-th communication step holds its outputs for k steps.

    Args:
        participants: Initialised participants with different names. Their outputs are the columns,
            in order. If several have the same output name, the participant's name is the prefix.
        wiring: Outputs or numbers for inputs that are not connected by equal names, by full name.
        step: Communication step, in [s].
        steps: Number of communication steps.
        every: Communication steps per step of a participant, by its name (default: 1).
        by_name: Whether inputs without wiring use the output of the same name. Otherwise they stay
            at their start values.
        changes: Conversions of inputs by full name, if they differ from those of the units.

    Raises:
        InputError: An input has no source, a size or a unit does not match, or the coupling does
            not match the participants.
        UnknownNameError: The wiring names a port that does not exist.

    Attributes:
        names: Names of the columns; the first is `time`.
        units: Units of the columns, by name; empty for a number without a unit.
        count: Number of rows of a complete run.
    """

    def __init__(
        self,
        participants: Sequence[Participant],
        wiring: Wiring,
        *,
        step: float,
        steps: int,
        coupling: Coupling | None = None,
        every: Mapping[str, int] | None = None,
        by_name: bool = True,
        changes: Mapping[str, Conversion] | None = None,
    ) -> None:
        self._step, self.count = step, steps + 1
        by_name_of = {p.name: p for p in participants}
        if len(by_name_of) < len(participants):
            raise InputError("two participants have the same name")
        groups, before = (coupling or Coupling()).stages(list(by_name_of))
        copies = connect(participants, wiring, by_name=by_name, changes=changes)
        turns = [
            Turn(by_name_of[name], copies[name], (every or {}).get(name, 1), stage)
            for stage, group in enumerate(groups)
            for name in group
        ]
        self.names, self.units, values = columns_of(participants)
        # Only participants with mapped names and units have warnings.
        self._warnings = [line for p in participants for line in getattr(p, "warnings", ())]
        timed = next((k for k, t in enumerate(turns) if t.participant.name == "controller"), None)
        self._tick_every = 1 if timed is None else turns[timed].every
        self._first_tick_row = int(timed is not None and turns[timed].stage >= before)
        timer = None if timed is None else _solve_time(turns[timed].participant)
        self._is_timed = timer is not None
        self._stepper = Stepper(
            turns,
            list(zip(values, column_limits(self.names, step)[1:], strict=True)),
            step=step,
            before=before,
            timed=-1 if timed is None else timed,
            timer=timer,
        )
        self._start_logs()

    def run(
        self,
        progress: Progress | None = None,
        pacer: Pacer | None = None,
        watch: Watch | None = None,
        sink: RowSink | None = None,
    ) -> Recording:
        """Run until the end, the first failure, or Ctrl-C.

        A row with a value that is not finite, or beyond any physical scale, is the last row.

        Args:
            progress: Called regularly with the number of completed steps.
            pacer: Timer of a real-time run; None to run as fast as possible.
            watch: Called as often as `progress`, with the rows so far.
            sink: Memory for the rows. It is updated after each step in real time, otherwise as
                often as `progress`, and closed at the end.
        """
        rows = np.empty((self.count, len(self.names))) if sink is None else sink.rows
        self._start_logs()
        failure: CardsflowError | None = None
        is_due = _always if pacer is None else _timed_reports()
        with collect_interrupts() as interrupted:
            try:
                for done in self._steps(rows, pacer, lambda: bool(interrupted)):
                    if interrupted:
                        raise SimulationError(INTERRUPTED)
                    if sink is not None:
                        sink.update(self._recorded)
                    if is_due():
                        if progress:
                            progress(done)
                        if watch:
                            watch(self.names, rows[: self._recorded])
            except CardsflowError as error:
                failure = self._root_cause(error, rows)
            except KeyboardInterrupt:
                failure = self._root_cause(SimulationError(INTERRUPTED), rows)
            if sink is not None:
                failure = self._close(sink) or failure
        if progress:
            progress(self._done)
        return self._recording(rows[: self._recorded], failure)

    def _start_logs(self) -> None:
        self._done = self._recorded = self._ticks = 0
        self._solve_times, self._lateness = NumberLog(), NumberLog()

    def _steps(
        self, rows: FloatArray, pacer: Pacer | None, is_interrupted: Callable[[], bool]
    ) -> Iterator[int]:
        """Take some steps per iteration, one in real time; yield the number of completed steps."""
        stepper, steps, times = self._stepper, self.count - 1, np.empty(_CHUNK)
        while (first := self._done) < steps:
            if pacer is not None:
                self._wait(pacer, first, is_interrupted)
            count = min(_CHUNK, steps - first) if pacer is None else 1
            stepper.done = stepper.recorded = stepper.ticks = 0
            try:
                stepper.run(first, count, _SLICE, rows[first:], times, is_interrupted)
            finally:
                self._done += stepper.done
                self._recorded += stepper.recorded
                self._ticks += stepper.ticks
                self._solve_times.extend(times[: stepper.ticks])
            self._require_good_row(rows)
            yield self._done
        if pacer is not None:
            self._wait(pacer, steps, is_interrupted)
        stepper.record(steps * self._step, rows[steps])
        self._recorded = self.count
        self._require_good_row(rows)

    def _wait(self, pacer: Pacer, k: int, is_interrupted: Callable[[], bool]) -> None:
        """Wait until step k starts. A step can take longer than a user waits after Ctrl-C."""
        lateness = pacer.wait(k * self._step, is_interrupted)
        if is_interrupted():
            raise SimulationError(INTERRUPTED)
        self._lateness.append(lateness)

    def _require_good_row(self, rows: FloatArray) -> None:
        """Raise the error that the last row shows."""
        if self._stepper.is_bad:
            error = row_error(self.names, rows[self._recorded - 1], self._step)
            assert error is not None
            raise error

    def _recording(self, rows: FloatArray, failure: CardsflowError | None) -> Recording:
        first, every = self._first_tick_row, self._tick_every
        recording = Recording(
            self.names,
            rows,
            self.units,
            np.arange(first, first + every * self._ticks, every, dtype=np.intp),
            self._solve_times.numbers() if self._is_timed else np.empty(0),
            failure,
            self._lateness.numbers(),
            self._warnings,
        )
        return _with_finite_solve_times(recording)

    def _root_cause(self, error: CardsflowError, rows: FloatArray) -> CardsflowError:
        """Return the error that ended the loop, preceded by a value that is not finite.

        A value that is not finite often causes another error later.
        """
        last = rows[self._recorded - 1] if self._recorded else np.zeros(1)
        cause = not_finite_error(self.names, last)
        if cause is None or str(cause) == str(error):
            return error
        return SimulationError(f"{cause}; {error}")

    def _close(self, sink: RowSink) -> CardsflowError | None:
        """Store the last rows and close the sink; return its failure, or None."""
        try:
            sink.update(self._recorded)
            sink.close()
        except CardsflowError as error:
            return error
        return None


def _always() -> bool:
    return True


def _timed_reports() -> Callable[[], bool]:
    """Return a function that returns whether a report is due, independent of the step duration."""
    due = 0.0

    def is_due() -> bool:
        nonlocal due
        now = time.monotonic()
        if now < due:
            return False
        due = now + _SLICE
        return True

    return is_due


def _solve_time(controller: Wired) -> Value | None:
    names = controller.output_names
    return (controller.outputs, names.index(SOLVE_TIME)) if SOLVE_TIME in names else None


def _with_finite_solve_times(recording: Recording) -> Recording:
    """Return the recording, with a failure if a tick's computation time is not finite."""
    if recording.failure is not None or np.isfinite(recording.solve_times).all():
        return recording
    bad = [row for row in recording.times_of_ticks() if not np.isfinite(row).all()]
    if not bad:
        return recording
    problem = not_finite_message(SOLVE_TIME, bad[0][1], bad[0][0])
    return replace(recording, failure=SimulationError(problem))


def columns_of(
    participants: Sequence[Wired],
) -> tuple[tuple[str, ...], dict[str, str], list[Value]]:
    """Return names and units of the columns, and the values of all columns except `time`.

    Args:
        participants: Their outputs are the columns, in order, except solve times.
    """
    count = Counter(name for p in participants for name in p.output_names)
    names, units = ["time"], {"time": "s"}
    values: list[Value] = []
    for p in participants:
        for k, name in enumerate(p.output_names):
            if name == SOLVE_TIME:
                continue
            values.append((p.outputs, k))
            names.append(name if count[name] == 1 else f"{p.name}.{name}")
            units[names[-1]] = p.units[name].name if name in p.units else ""
    return tuple(names), units, values
