"""Recordings of runs: columns, ticks, failures; sinks and callbacks of running ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu.utils.arrays import FloatArray

Progress = Callable[[int], None]
"""Called with the number of steps done."""
Watch = Callable[[tuple[str, ...], FloatArray], None]
"""Called with the names of the columns and a view of the rows so far, shape (rows, len(names))."""


class RowSink(Protocol):
    """Memory for the rows of a run, which is notified as they are filled."""

    @property
    def rows(self) -> FloatArray:
        """The table to be filled, shape (count, columns)."""

    def update(self, filled: int) -> None:
        """Take note that so many rows are filled; SimulationError where they cannot be kept."""

    def close(self) -> None:
        """Write what is still buffered; SimulationError where that fails."""


@dataclass(frozen=True)
class Recording:
    """The columns of a run, one row a communication point.

    Attributes:
        names: Name of every column; the first is `time`.
        rows: Shape (rows, len(names)).
        units: Unit of every column, by its name; empty for a number without one.
        ticks: Rows that are the first to show the outputs of a tick of the controller.
        solve_times: Computation time of each tick, in [s]; empty where the controller has no such
            output. Apart from the rows, which are equal whenever the same experiment is run.
        failure: Why the run ended early, None when it is complete.
        lateness: How late each step began, and the last one ended, in [s], where they are paced.
        warnings: What participants had to assume, a line each.
    """

    names: tuple[str, ...]
    rows: FloatArray
    units: Mapping[str, str]
    ticks: list[int]
    solve_times: list[float]
    failure: CardsflowError | None
    lateness: list[float] = field(default_factory=list)
    warnings: Sequence[str] = ()

    @property
    def columns(self) -> dict[str, FloatArray]:
        """The columns by name, shape (rows,) each."""
        return dict(zip(self.names, self.rows.T, strict=True))

    def times_of_ticks(self) -> FloatArray:
        """Time of each tick and its computation time, in [s], shape (ticks, 2).

        Without rows where computation times are not known.
        """
        known = [k for k in self.ticks if k < len(self.rows)][: len(self.solve_times)]
        return np.column_stack([self.rows[known, 0], self.solve_times[: len(known)]])
