"""The pace of runs with hardware, which goes by its own clock, and the report on its exchanges."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cardsflow_fmu.cosim.pace import Pace
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.utils.arrays import FloatArray


class HardwarePace(Pace):
    """The conditions for a run with hardware, as a context.

    Args:
        step: Communication step, in [s].
        realtime: Whether to pace steps; those with hardware that goes by a clock pace themselves.
        hardware: Settings of the hardware.
    """

    def __init__(self, step: float, realtime: bool, hardware: HardwareSettings) -> None:
        super().__init__(step, realtime and not hardware.goes_by_clock)
        self._hardware = hardware
        self._is_realtime = realtime or hardware.goes_by_clock

    def judged(self, recording: Recording) -> Recording:
        """Return the recording, with a failure if the hardware was lost at the end.

        Without a state for longer than the device's watchdog, the last commands may be lost.
        """
        if recording.failure is not None or not self._hardware.is_paced:
            return recording
        silence = recording.columns.get("age", np.zeros(1))[-1]
        if silence <= self._hardware.watchdog:
            return recording
        what = f"the hardware was lost at the end: the newest state is {silence:.3g} s old"
        return replace(recording, failure=HardwareError(what))

    def report(self, recording: Recording) -> dict[str, Any]:
        """Return the part of the summary."""
        columns, lateness = recording.columns, np.array(recording.lateness)
        if self._hardware.goes_by_clock:
            lateness = columns.get("lateness", np.empty(0))[1:]
        return {
            **self._timeliness(lateness),
            "hardware": {
                "link": self._hardware.link,
                "mode": self._hardware.mode,
                **_exchanges(columns),
            },
        }


def _exchanges(columns: dict[str, FloatArray]) -> dict[str, Any]:
    """Statistics of the hardware's diagnostics, if they are recorded."""
    missed, trips = columns.get("missed", np.empty(0))[1:], columns.get("round_trip_time")
    if trips is None or not missed.size:
        return {"missed": None, "round_trip": None, "oldest_state": None, "unit": "s"}
    median, most = np.quantile(trips[1:], [0.5, 0.99])
    return {
        "missed": int(missed[-1]),
        "round_trip": {"median": float(median), "p99": float(most), "max": float(trips[1:].max())},
        "oldest_state": float(columns["age"][1:].max()),
        "unit": "s",
    }
