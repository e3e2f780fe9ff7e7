"""Robot that replays a recording: its states are the recorded states for any commands."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.recording import HardwareRecording
from cardsflow_fmu.utils.arrays import FloatArray

_ROUNDING = 0.01
"""Tolerance between a time and the time of a row, as a fraction of a step."""


class ReplayedRobot:
    """Robot that returns recorded states over time. In lockstep, each step is one row.

    After the end of the recording it reports a failure, like hardware that is switched off.

    Raises:
        InputError: The recording contains no states.

    Attributes:
        commands: Number of commands.
        states: Number of state values.
        duration: Duration of the recording, in [s].
        deviation: Maximum difference so far between a command and the command that was recorded
            for the same time, in the unit of the command.
    """

    def __init__(self, recording: HardwareRecording) -> None:
        header = recording.header
        self.commands, self.states = header.commands, header.states
        has_state = np.isfinite(recording.states).all(axis=1)
        if not has_state.any():
            raise InputError("the recording contains no states to replay")
        self._step = header.step
        origin = recording.t[0]
        self._command_times = recording.t - origin
        self._commands = recording.commands
        # In lockstep, a recorded state belongs to the end of the step.
        delay = self._step if header.lockstep else 0.0
        self._state_times = self._command_times[has_state] + delay
        self.duration = float(self._command_times[-1]) + delay
        self._states = recording.states[has_state]
        self._start_state = np.array(header.start_state or self._states[0])
        self.reset()

    def reset(self) -> None:
        """Return to the beginning of the recording."""
        self._elapsed = 0.0
        self._stopped = False
        self.deviation = 0.0

    def apply(self, command: FloatArray) -> None:
        """Compare a command, shape (commands,), with the command recorded for this time."""
        row = self._newest_row(self._command_times)
        if row >= 0 and self._elapsed - self._command_times[row] < (1 - _ROUNDING) * self._step:
            difference = np.max(np.abs(command - self._commands[row]))
            self.deviation = max(self.deviation, float(difference))

    def advance(self, dt: float) -> None:
        """Advance the replay by dt, in [s].

        Raises:
            HardwareError: The end of the recording is reached.
        """
        if self._stopped:
            return
        self._elapsed += dt
        if self._elapsed > self.duration + 0.5 * self._step:
            raise HardwareError(f"the recording ends after {self.duration:.6g} s")

    def state(self) -> FloatArray:
        """Return the newest recorded state at the current time, shape (states,)."""
        row = self._newest_row(self._state_times)
        return (self._start_state if row < 0 else self._states[row]).copy()

    def safe(self) -> None:
        """Stop the replay until the next run."""
        self._stopped = True

    def _newest_row(self, times: FloatArray) -> int:
        """Return the last row at or before the current time, or -1 if no row exists."""
        now = self._elapsed + _ROUNDING * self._step
        return int(np.searchsorted(times, now, side="right")) - 1
