"""Pacing of runs with hardware that moves in real time, and the report on its exchanges."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from cardsflow_fmu.cosim.pace import Pace
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.hardware.protocol.errors import HardwareError

_SAFE = "entered its safe state"
"""Part of the message about a device in its safe state."""


class HardwarePace(Pace):
    """Context for the timing of a run with hardware."""

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
        problem = f"the hardware did not respond at the end: the newest state is {age:.3g} s old"
        return replace(recording, failure=HardwareError(problem))

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
                "watchdog_expired": self._watchdog_expired(recording),
            },
        }

    def _watchdog_expired(self, recording: Recording) -> bool | None:
        """Return whether the device's watchdog must have expired during the run.

        The device may also have answered with its safe state, which ends a run as a failure. None
        without recorded ages.
        """
        ages = recording.columns.get("age", np.empty(0))[1:]
        if not self._hardware.is_paced:
            return False
        if isinstance(recording.failure, HardwareError) and _SAFE in str(recording.failure):
            return True
        return bool(ages.max() > self._hardware.watchdog) if ages.size else None
