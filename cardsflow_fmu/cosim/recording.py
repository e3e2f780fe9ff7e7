"""Recordings of runs: columns, ticks, failures; logs, sinks and callbacks during a run."""

from __future__ import annotations

import tempfile
import weakref
from array import array
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import BinaryIO, Protocol

import numpy as np

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu.utils.arrays import FloatArray, IntArray

Progress = Callable[[int], None]
"""Callback with the number of completed steps."""
Watch = Callable[[tuple[str, ...], FloatArray], None]
"""Callback with the column names and a view of the rows so far, shape (rows, len(names))."""


class RowSink(Protocol):
    """Memory for the rows of a run, which is notified when rows are complete."""

    @property
    def rows(self) -> FloatArray:
        """Table for the rows, shape (count, columns)."""

    def update(self, filled: int) -> None:
        """Store the first `filled` rows; raise SimulationError if they cannot be stored."""

    def close(self) -> None:
        """Write all buffered rows; raise SimulationError on failure."""


_BLOCK = 2**16


class NumberLog:
    """Numbers that are appended one by one; full blocks are stored in a temporary file."""

    def __init__(self) -> None:
        self._block = array("d")
        self._file: BinaryIO | None = None

    def append(self, number: float) -> None:
        """Append a number."""
        self._block.append(number)
        if len(self._block) >= _BLOCK:
            self._store()

    def extend(self, numbers: FloatArray) -> None:
        """Append numbers, shape (count,)."""
        self._block.frombytes(numbers.tobytes())
        if len(self._block) >= _BLOCK:
            self._store()

    def _store(self) -> None:
        """Write the block to the file."""
        if self._file is None:
            self._file = tempfile.TemporaryFile()  # noqa: SIM115 - open as long as the log
            weakref.finalize(self, self._file.close)
        self._block.tofile(self._file)
        self._block = array("d")

    def numbers(self) -> FloatArray:
        """Return all numbers, shape (count,)."""
        parts = [np.frombuffer(self._block)] if self._block else []
        if self._file is not None:
            self._file.seek(0)
            parts.insert(0, np.fromfile(self._file))
            self._file.seek(0, 2)
        return np.concatenate(parts) if parts else np.empty(0)


@dataclass(frozen=True)
class Recording:
    """Columns of a run, one row per communication point.

    Attributes:
        names: Names of the columns; the first is `time`.
        rows: Values, shape (rows, len(names)).
        units: Units of the columns, by name; empty for a number without a unit.
        ticks: For each controller tick, the first row with its outputs, shape (ticks,).
        solve_times: Computation time of each tick, shape (ticks,), in [s]; empty if the
            controller has no such output. They are not columns, so that equal experiments have
            equal rows.
        failure: Error that ended the run early, or None if the run is complete.
        lateness: Lateness of the start of each step and of the end of the last step, in [s], of
            real-time runs.
        warnings: Assumptions of participants, one line each.
    """

    names: tuple[str, ...]
    rows: FloatArray
    units: Mapping[str, str]
    ticks: IntArray
    solve_times: FloatArray
    failure: CardsflowError | None
    lateness: FloatArray = field(default_factory=lambda: np.empty(0))
    warnings: Sequence[str] = ()

    @property
    def columns(self) -> dict[str, FloatArray]:
        """Columns by name, shape (rows,) each."""
        return dict(zip(self.names, self.rows.T, strict=True))

    def times_of_ticks(self) -> FloatArray:
        """Return the time of each tick and its computation time, in [s], shape (ticks, 2).

        The array is empty if computation times are unknown.
        """
        recorded = self.ticks[self.ticks < len(self.rows)][: len(self.solve_times)]
        return np.column_stack([self.rows[recorded, 0], self.solve_times[: len(recorded)]])
