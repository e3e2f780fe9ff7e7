"""The loop of a run over its steps: recording, progress, interruption, failures."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping

import numpy as np

from addin_sdfusion.robot import CardsflowError, SimulationError
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
            sink: Memory for the rows; it is updated at every step and closed at the end.
        """
        self._require_ready()
        rows = np.empty((self.count, len(self.names))) if sink is None else sink.rows
        self._recorded = done = 0
        failure: CardsflowError | None = None
        divergence = Divergence(self.names)
        with interruptible() as interrupted:
            try:
                for done in self._steps(rows, pacer):
                    if sink is not None:
                        sink.update(self._recorded)
                    if interrupted:
                        raise SimulationError(INTERRUPTED)
                    if done % self._report_every == 0:
                        divergence.look(rows[: self._recorded])
                        if progress:
                            progress(done)
                        if watch:
                            watch(self.names, rows[: self._recorded])
                divergence.look(rows[: self._recorded])
            except CardsflowError as error:
                failure = error
            except KeyboardInterrupt:
                failure = SimulationError(INTERRUPTED)
            if sink is not None:
                failure = self._close(sink) or failure
        if progress:
            progress(done)
        return self._recording(rows[: self._recorded], failure)

    def _require_ready(self) -> None:  # noqa: B027 - most loops always are
        """Refuse a run that cannot be made."""

    @abstractmethod
    def _steps(self, rows: FloatArray, pacer: Pacer | None) -> Iterator[int]:
        """Step and record; yields the number of steps done."""

    @abstractmethod
    def _recording(self, rows: FloatArray, failure: CardsflowError | None) -> Recording:
        """The rows with their ticks and times."""

    def _close(self, sink: RowSink) -> CardsflowError | None:
        """Pass the last rows on and close the sink; its failure, None if there is none."""
        try:
            sink.update(self._recorded)
            sink.close()
        except CardsflowError as error:
            return error
        return None
