"""The fixed-step co-simulation master: participants of any number, under a named coupling."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, SimulationError
from cardsflow_fmu.signals.ports import SOLVE_TIME
from cardsflow_fmu.signals.units import Conversion
from cardsflow_fmu.utils.interrupts import INTERRUPTED, interruptible

from .coupling import Coupling
from .pacing import Pacer
from .participant import FloatArray, Participant
from .wiring import Copy, Wiring, connect, runs

if TYPE_CHECKING:
    from cardsflow_fmu.results.journal import Journal

Progress = Callable[[int], None]
Watch = Callable[[tuple[str, ...], FloatArray], None]
"""Given the names of the columns and a view of the rows so far, shape (rows, len(names))."""


@dataclass(frozen=True, slots=True)
class _Turn:
    """A participant in the order of a step.

    Attributes:
        step: Its step.
        copies: What it is given before.
        every: Communication steps between two of its own.
        is_ticking: Whether it is the controller, whose ticks are noted.
    """

    step: Callable[[float, float], None]
    copies: list[Copy]
    every: int
    is_ticking: bool


@dataclass(frozen=True)
class Recording:
    """What a run gave, one row a communication point.

    Attributes:
        names: Name of every column; the first is `time`.
        rows: Shape (rows, len(names)).
        units: Unit of every column that has one, by its name.
        ticks: Rows at which what the controller gave at a tick stands first.
        solve_times: How long the controller took at each tick, in [s], where it tells. Apart from
            the rows, which are equal whenever the same experiment is run.
        failure: Why the run ended early, None when it is complete.
        lateness: How late each step began, and the last one ended, in [s], where they are paced.
    """

    names: tuple[str, ...]
    rows: FloatArray
    units: Mapping[str, str]
    ticks: list[int]
    solve_times: list[float]
    failure: CardsflowError | None
    lateness: list[float] = field(default_factory=list)

    def times_of_ticks(self) -> FloatArray:
        """Time of each tick and how long it took to compute, in [s], shape (ticks, 2).

        Without rows where the controller does not tell.
        """
        known = [k for k in self.ticks if k < len(self.rows)][: len(self.solve_times)]
        return np.column_stack([self.rows[known, 0], self.solve_times[: len(known)]])


class Master:
    """Steps participants that feed each other.

    A participant that is stepped every k-th communication step only holds its outputs for k steps.

    Args:
        participants: Initialised, with different names; their outputs are the columns, in order. A
            name that several of them have is led by the participant's.
        wiring: Outputs, or numbers, for inputs that are not wired by equal names, by full name.
        step: Communication step, in [s].
        steps: Number of communication steps.
        coupling: The coupling scheme.
        every: Communication steps between two steps of a participant, by its name; 1 if absent.
        by_name: Whether inputs that the wiring leaves out take the output of the same name;
            otherwise they stay at their start values.
        changes: What is done to the value of an input on its way, by its full name, where that is
            not what the units of both ends ask for.

    Attributes:
        names: Name of every column; the first is `time`.
        units: Unit of every column that has one, by its name.

    Raises:
        InputError: An input has no output to take its value from, a size or a unit does not fit, or
            the coupling does not fit the participants.
        UnknownNameError: The wiring names a port that does not exist.
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
        self._step, self._steps = step, steps
        by_its_name = {p.name: p for p in participants}
        if len(by_its_name) < len(participants):
            raise InputError("two participants have the same name")
        groups, before = (coupling or Coupling()).stages(list(by_its_name))
        copies = connect(participants, wiring, by_name=by_name, changes=changes)
        ticking = by_its_name.get("controller")
        stages = [
            [
                _Turn(p.step, copies[p.name], (every or {}).get(p.name, 1), p is ticking)
                for p in map(by_its_name.__getitem__, group)
            ]
            for group in groups
        ]
        self._before, self._after = stages[:before], stages[before:]
        self.names, self.units, self._columns = columns_of(participants)
        self._ticks: list[int] = []
        self._solve_times: list[float] = []
        self._lateness: list[float] = []
        self._pacer: Pacer | None = None
        outputs = () if ticking is None else ticking.output_names
        self._controller_outputs = np.empty(0) if ticking is None else ticking.outputs
        self._timer = outputs.index(SOLVE_TIME) if SOLVE_TIME in outputs else None

    def run(
        self,
        progress: Progress | None = None,
        pacer: Pacer | None = None,
        watch: Watch | None = None,
        journal: Journal | None = None,
    ) -> Recording:
        """Run to the end, to the first failure, or until Ctrl-C.

        Args:
            progress: Called now and then with the number of steps done.
            pacer: Makes steps wait for their time; none when None, as fast as can be.
            watch: Called as often as `progress` with what has been recorded.
            journal: Begun; holds the rows, and takes note of them at every step.
        """
        rows = np.empty((self.count, len(self.names))) if journal is None else journal.rows
        self._ticks, self._solve_times, self._lateness = [], [], []
        self._pacer = pacer
        failure: CardsflowError | None = None
        self._recorded = done = 0
        with interruptible() as interrupted:
            try:
                for done in self._loop(rows):
                    if journal is not None:
                        journal.update(self._recorded)
                    if interrupted:
                        raise SimulationError(INTERRUPTED)
                    if progress and done % 128 == 0:
                        progress(done)
                    if watch and done % 128 == 0:
                        watch(self.names, rows[: self._recorded])
            except CardsflowError as error:
                failure = error
            except KeyboardInterrupt:
                failure = SimulationError(INTERRUPTED)
            if journal is not None:
                failure = self._end(journal) or failure
        if progress:
            progress(done)
        recorded = rows[: self._recorded]
        return Recording(
            self.names,
            recorded,
            self.units,
            self._ticks,
            self._solve_times,
            failure,
            self._lateness,
        )

    def _loop(self, rows: FloatArray) -> Iterator[int]:
        """One communication step an iteration; yields the number of steps done."""
        for k in range(self._steps):
            if self._pacer is not None:
                self._wait(self._pacer, k)
            for stage in self._before:
                self._advance(stage, k, k)
            self._record(rows[k], k * self._step)
            for stage in self._after:
                self._advance(stage, k, k + 1)
            yield k + 1
        if self._pacer is not None:
            self._wait(self._pacer, self._steps)
        self._record(rows[self._steps], self._steps * self._step)

    @property
    def count(self) -> int:
        """Number of rows that a complete run gives."""
        return self._steps + 1

    def _end(self, journal: Journal) -> CardsflowError | None:
        """Let the journal take the last rows; what is in its way, None if nothing."""
        try:
            journal.update(self._recorded)
            journal.close()
        except CardsflowError as error:
            return error
        return None

    def _wait(self, pacer: Pacer, k: int) -> None:
        """Wait for the time of step k."""
        self._lateness.append(pacer.wait(k * self._step))

    def _advance(self, stage: Sequence[_Turn], k: int, row: int) -> None:
        """Give every participant of a stage its inputs, then step every one.

        Args:
            stage: The participants.
            k: Number of the step.
            row: The first row to show it.
        """
        step = self._step
        for turn in stage:
            if k % turn.every == 0:
                for copy in turn.copies:
                    copy()
        for turn in stage:
            if k % turn.every:
                continue
            turn.step(k * step, turn.every * step)
            if turn.is_ticking:
                self._ticks.append(row)
                if self._timer is not None:
                    self._solve_times.append(self._controller_outputs.item(self._timer))

    def _record(self, row: FloatArray, t: float) -> None:
        row[0] = t
        for outputs, columns in self._columns:
            row[columns] = outputs
        self._recorded += 1


def columns_of(
    participants: Sequence[Participant],
) -> tuple[tuple[str, ...], dict[str, str], list[tuple[FloatArray, slice]]]:
    """Names of the columns, their units, and which values they show, as views of the outputs.

    Args:
        participants: Their outputs are the columns, in order; times of solving are none.
    """
    count = Counter(name for p in participants for name in p.output_names)
    names, units, columns = ["time"], {"time": "s"}, []
    for p in participants:
        kept = [k for k, name in enumerate(p.output_names) if name != SOLVE_TIME]
        begin = len(names)
        for run in runs(kept):
            end = begin + run.stop - run.start
            columns.append((p.outputs[run], slice(begin, end)))
            begin = end
        for k in kept:
            name = p.output_names[k]
            names.append(name if count[name] == 1 else f"{p.name}.{name}")
            if name in p.units:
                units[names[-1]] = p.units[name].name
    return tuple(names), units, columns
