"""The pace of a run: as fast as it can, or by the clock."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Any, Self

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray

from .pacing import Pacer, real_time_priority, timeliness, without_collections
from .recording import Recording


class Pace:
    """The conditions for a run by the clock, as a context; none where a run needs no clock.

    Args:
        step: Communication step, in [s].
        realtime: Whether steps wait for their time.

    Attributes:
        pacer: Pacer of the master; None where it does not wait.
    """

    def __init__(self, step: float, realtime: bool) -> None:
        self._step, self._by_the_clock = step, realtime
        self.pacer = Pacer(step) if realtime else None
        self._conditions = ExitStack()
        self._scheduling: str | None = None

    def __enter__(self) -> Self:
        if self._by_the_clock:
            self._conditions.enter_context(without_collections())
            self._scheduling = self._conditions.enter_context(real_time_priority())
        return self

    def __exit__(self, *exception: object) -> None:
        self._conditions.close()

    def judged(self, recording: Recording) -> Recording:
        """The recording, with a failure where the run did not end as it has to."""
        return recording

    def report(self, recording: Recording) -> dict[str, Any]:
        """The part of the summary: empty without clock and hardware."""
        return self._timeliness(np.array(recording.lateness))

    def _timeliness(self, lateness: FloatArray) -> dict[str, Any]:
        if self._scheduling is None:
            return {}
        return {
            "real_time": {**timeliness(lateness, self._step), "scheduling": self._scheduling},
        }
