"""Pacing of a run: as fast as possible, or in real time."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any, Self

from cardsflow_fmu.utils.arrays import FloatArray

from .pacing import Pacer, real_time_priority, timeliness, without_collections
from .recording import Recording


class Pace:
    """Context manager that prepares the process for a run in real time, if required.

    Attributes:
        pacer: Timer of the master, or None if the run is not in real time.
    """

    def __init__(self, step: float, realtime: bool) -> None:
        self._step, self._is_realtime = step, realtime
        self.pacer = Pacer(step) if realtime else None
        self._conditions = ExitStack()
        self._scheduling: str | None = None

    def __enter__(self) -> Self:
        if self._is_realtime:
            self._conditions.enter_context(without_collections())
            self._scheduling = self._conditions.enter_context(real_time_priority())
        return self

    def __exit__(self, *exception: object) -> None:
        self._conditions.close()

    def with_final_check(self, recording: Recording) -> Recording:
        """Return the recording, with a failure if the run did not end as required."""
        return recording

    def report(self, recording: Recording) -> dict[str, Any]:
        """Return the entries for the summary of the run; empty if it is not in real time."""
        return self._timeliness(recording.lateness)

    def _timeliness(self, lateness: FloatArray) -> dict[str, Any]:
        if self._scheduling is None:
            return {}
        return {
            "real_time": {**timeliness(lateness, self._step), "scheduling": self._scheduling},
        }
