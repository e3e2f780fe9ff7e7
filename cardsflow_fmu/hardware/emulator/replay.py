"""The robot of a recording: its states are the recorded ones, whatever the commands."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.recording import HardwareRecording
from cardsflow_fmu.utils.arrays import FloatArray

_ROUNDING = 0.01
"""Part of a step by which a time may miss that of a row."""


class ReplayedRobot:
    """The recorded states over time; in lockstep one row per step.

    Behind the end of the recording it fails, as hardware that is switched off.

    Raises:
        InputError: No state has been recorded.

    Attributes:
        commands: Number of commands.
        states: Number of states.
        deviation: Largest difference so far between a command and the one recorded for the same
            time, in the command's unit.
    """

    def __init__(self, recording: HardwareRecording) -> None:
        header = recording.header
        self.commands, self.states = header.commands, header.states
        came = np.isfinite(recording.states).all(axis=1)
        if not came.any():
            raise InputError("no state has been recorded: there is nothing to replay")
        self._step = header.step
        origin = recording.t[0]
        self._command_times = recording.t - origin
        self._commands = recording.commands
        late = self._step if header.lockstep else 0.0  # in lockstep a state is the step's end
        self._state_times = self._command_times[came] + late
        self._duration = float(self._command_times[-1]) + late
        self._states = recording.states[came]
        self._start_state = np.array(header.start_state or self._states[0])
        self.reset()

    @property
    def duration(self) -> float:
        """Length of the recording, in [s]."""
        return self._duration

    def reset(self) -> None:
        """Back to the beginning."""
        self._elapsed = 0.0
        self._stopped = False
        self.deviation = 0.0

    def apply(self, command: FloatArray) -> None:
        """Compare a command, shape (commands,), with what was recorded for this time."""
        row = self._newest(self._command_times)
        if row >= 0 and self._elapsed - self._command_times[row] < (1 - _ROUNDING) * self._step:
            difference = np.max(np.abs(command - self._commands[row]))
            self.deviation = max(self.deviation, float(difference))

    def advance(self, dt: float) -> None:
        """Go on by dt, in [s].

        Raises:
            HardwareError: The recording is over.
        """
        if self._stopped:
            return
        self._elapsed += dt
        if self._elapsed > self.duration + 0.5 * self._step:
            raise HardwareError(f"the recording is over after {self.duration:.6g} s")

    def state(self) -> FloatArray:
        """Return the newest state recorded until now, shape (states,)."""
        row = self._newest(self._state_times)
        return (self._start_state if row < 0 else self._states[row]).copy()

    def safe(self) -> None:
        """Hold the state until the next run."""
        self._stopped = True

    def _newest(self, times: FloatArray) -> int:
        """Return the last row that is not in the future; -1 if there is none."""
        now = self._elapsed + _ROUNDING * self._step
        return int(np.searchsorted(times, now, side="right")) - 1
