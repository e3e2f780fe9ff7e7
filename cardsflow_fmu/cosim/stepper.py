"""Steps of connected participants in C; see csrc/master.h."""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.compiled.library import address, run_library

from .participant import Copy, CStep, Participant

_STEP = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double)
_PAUSE, _FAILED = -1, 1
_RAN, _PARTICIPANT_FAILED = 0, 1


@dataclass(frozen=True, slots=True)
class Turn:
    """Participant in the order of a step.

    Attributes:
        copies: Copies to its inputs, made before the step.
        every: Number of communication steps per step of the participant.
        stage: Number of its stage. All participants of a stage receive their inputs before any of
            them steps.
    """

    participant: Participant
    copies: list[Copy]
    every: int
    stage: int


class _Progress(ctypes.Structure):
    """Result of a call; see `master_progress` in csrc/master.h."""

    _fields_ = (
        ("done", ctypes.c_int64),
        ("rows", ctypes.c_int64),
        ("ticks", ctypes.c_int64),
        ("turn", ctypes.c_int32),
        ("code", ctypes.c_int32),
    )


Value = tuple[FloatArray, int]
"""Value in memory: an array and an index."""


class Stepper:
    """Participants in C, with their connections and recorded values.

    A participant without a function in C is a callback. Exceptions do not pass through C; `run`
    raises them again.

    Args:
        turns: The participants in order.
        columns: Recorded values, with the largest absolute value of each.
        step: Communication step, in [s].
        before: Number of stages that step before a row is recorded.
        timed: Number of the turn whose steps are ticks, or -1.
        timer: Value that is recorded at each tick, or None.

    Attributes:
        done, recorded, ticks: Number of completed steps, rows and ticks in the last call of `run`.
        is_bad: Whether the last row has a value beyond its limit.
    """

    def __init__(
        self,
        turns: Sequence[Turn],
        columns: Sequence[tuple[Value, float]],
        *,
        step: float,
        before: int,
        timed: int,
        timer: Value | None,
    ) -> None:
        self._turns, self._step = turns, step
        self.done = self.recorded = self.ticks = 0
        self.is_bad = False
        self._error: BaseException | None = None
        self._is_interrupted: Callable[[], bool] = lambda: False
        self._progress = _Progress()
        self._buffers: list[Any] = [*turns, columns, timer]  # C stores pointers to their memory
        library = self._library = run_library()
        plans = [(turn, _copies(turn)) for turn in turns]
        count = sum(len(copies) for _, copies in plans)
        self._master = ctypes.c_void_p(library.master_open(len(turns), count, len(columns)))
        assert self._master
        weakref.finalize(self, library.master_close, self._master)
        for turn, copies in plans:
            function, instance = self._function(turn.participant)
            library.master_add_turn(self._master, function, instance, turn.every, turn.stage)
            for is_after, copy in copies:
                self._add_copy(is_after, copy)
        for value, limit in columns:
            library.master_add_column(self._master, _pointer(value), limit)
        library.master_set_step(self._master, step, before)
        library.master_set_timer(self._master, timed, None if timer is None else _pointer(timer))

    def run(
        self,
        first: int,
        count: int,
        seconds: float,
        rows: FloatArray,
        times: FloatArray,
        is_interrupted: Callable[[], bool],
    ) -> None:
        """Run steps until `count` are complete, a time is over, or the first failure.

        Args:
            count: Maximum number of steps.
            seconds: Time after which no step starts, in [s].
            rows: Memory for the rows of the steps, shape (count or more, 1 + columns).
            times: Memory for the timer at each tick, shape (count or more,).
            is_interrupted: Called after each step of a participant in Python. If it returns true,
                the call ends after this step.

        Raises:
            BaseException: The error of a participant.
        """
        assert rows.flags.c_contiguous
        assert count <= min(len(rows), len(times))
        self._error, self._is_interrupted, progress = None, is_interrupted, self._progress
        end = self._library.master_run(
            *(self._master, first, count, seconds, rows.ctypes.data, times.ctypes.data),
            ctypes.byref(progress),
        )
        self.done, self.recorded, self.ticks = progress.done, progress.rows, progress.ticks
        self.is_bad = end not in (_RAN, _PARTICIPANT_FAILED)
        if self._error is not None:
            raise self._error
        if end == _PARTICIPANT_FAILED:
            raise self._failure(progress.turn, progress.code, (first + self.done) * self._step)

    def record(self, t: float, row: FloatArray) -> None:
        """Write the values at the end of a run to a row."""
        self.done, self.recorded, self.ticks = 0, 1, 0
        self.is_bad = self._library.master_record(self._master, t, row.ctypes.data) != _RAN

    def _failure(self, turn: int, code: int, t: float) -> CardsflowError:
        c_step = _c_step(self._turns[turn].participant)
        assert c_step is not None
        return c_step.failure(code, t)

    def _function(self, participant: Participant) -> tuple[int, int | None]:
        """Return the step of a participant as a C function and its first argument."""
        c_step = _c_step(participant)
        if c_step is not None:
            return c_step.function, c_step.instance
        reference = weakref.ref(self)  # a callback that refers to this object would keep it alive
        step = participant.step

        def call(_: int | None, t: float, h: float) -> int:
            stepper = reference()
            assert stepper is not None
            try:
                step(t, h)
            except BaseException as error:
                stepper._error = error
                return _FAILED
            return _PAUSE if stepper._is_interrupted() else 0

        callback = _STEP(call)
        self._buffers.append(callback)
        return address(callback), None

    def _add_copy(self, is_after: bool, copy: Copy) -> None:
        self._buffers += [copy.source, copy.target]
        source, target = (copy.source, copy.source_index), (copy.target, copy.target_index)
        self._library.master_add_copy(
            *(self._master, is_after, _pointer(source), _pointer(target)),
            *(copy.form, copy.change.factor, copy.change.offset),
        )


def _c_step(participant: Participant) -> CStep | None:
    step: CStep | None = getattr(participant, "c_step", None)
    return step


def _copies(turn: Turn) -> list[tuple[bool, Copy]]:
    """Return the copies of a turn, with whether they are made after the step."""
    incoming: list[Copy] = getattr(turn.participant, "incoming", [])
    outgoing: list[Copy] = getattr(turn.participant, "outgoing", [])
    before = [(False, copy) for copy in [*turn.copies, *incoming]]
    return [*before, *((True, copy) for copy in outgoing)]


def _pointer(value: Value) -> int:
    array, index = value
    assert array.dtype == float
    assert 0 <= index < len(array)
    return int(array.ctypes.data + index * array.strides[0])
