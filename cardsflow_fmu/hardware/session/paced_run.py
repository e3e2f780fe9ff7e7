"""Pacing of runs with hardware that moves in real time, and the report on its exchanges."""

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
    """Context for the timing of a run with hardware.

    Args:
        step: Communication step, in [s].
        realtime: Whether to pace steps. Sessions with hardware in real time pace the steps
            themselves.
        hardware: Hardware settings.
    """

    def __init__(self, step: float, realtime: bool, hardware: HardwareSettings) -> None:
        super().__init__(step, realtime and not hardware.moves_in_real_time)
        self._hardware = hardware
        self._is_realtime = realtime or hardware.moves_in_real_time

    def with_final_check(self, recording: Recording) -> Recording:
        """Return the recording, with a failure if the hardware did not respond at the end.

        If the newest state is older than the device's watchdog, the last commands may be lost.
        """
        if recording.failure is not None or not self._hardware.is_paced:
            return recording
        age = recording.columns.get("age", np.zeros(1))[-1]
        if age <= self._hardware.watchdog:
            return recording
        what = f"the hardware did not respond at the end: the newest state is {age:.3g} s old"
        return replace(recording, failure=HardwareError(what))

    def report(self, recording: Recording) -> dict[str, Any]:
        """Return the entries for the summary of the run."""
        columns, lateness = recording.columns, recording.lateness
        if self._hardware.moves_in_real_time:
            lateness = columns.get("lateness", np.empty(0))[1:]
        return {
            **self._timeliness(lateness),
            "hardware": {
                "link": self._hardware.link,
                "mode": self._hardware.mode,
                **_exchange_statistics(columns),
            },
        }


def _exchange_statistics(columns: dict[str, FloatArray]) -> dict[str, Any]:
    """Return statistics of missed exchanges, round trip times and ages, if they are recorded."""
    missed, trips = columns.get("missed", np.empty(0))[1:], columns.get("round_trip_time")
    if trips is None or not missed.size:
        return {"missed": None, "round_trip": None, "oldest_state": None, "unit": "s"}
    median, p99 = np.quantile(trips[1:], [0.5, 0.99])
    return {
        "missed": int(missed[-1]),
        "round_trip": {"median": float(median), "p99": float(p99), "max": float(trips[1:].max())},
        "oldest_state": float(columns["age"][1:].max()),
        "unit": "s",
    }
