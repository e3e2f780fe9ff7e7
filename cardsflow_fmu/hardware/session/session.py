"""A run with hardware: what is wanted passes the guard, becomes commands, and states come back."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack, suppress

import numpy as np

from addin_sdfusion.robot import CardsflowError, Robot
from cardsflow_fmu.cosim.pacing import Pacer, real_time_priority
from cardsflow_fmu.experiment.hardware_settings import HardwareSettings
from cardsflow_fmu.hardware.links.link import HardwareLink
from cardsflow_fmu.hardware.protocol.clock import Clock
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.exchange import Exchange
from cardsflow_fmu.hardware.protocol.frame import Flag
from cardsflow_fmu.hardware.protocol.handshake import Hello
from cardsflow_fmu.hardware.protocol.recording import Recorder
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.interrupts import ignoring_interrupts
from sim_dart import MusclePaths

from .gravity_compensation import holding_forces
from .motors import MotorMap
from .safety import Guard

STARTING, RUNNING, HOLDING, STOPPED = range(4)

_ANSWER = 0.6
"""Part of a step in which an answer is waited for; the rest is the controller's."""
_SPARE = 0.5
"""How much longer than planned a ramp down may take, in [s]."""


class HardwareSession:
    """Hardware that is driven step by step, and led to its safe state in the end.

    Args:
        robot: The robot.
        settings: How it is driven.
        link: The way to it; not open yet.
        hello: What is to be agreed with it.
        make_recorder: Makes what takes every exchange, once the link is open; nothing when None.
        clock: What tells the time at both ends of the link.

    Attributes:
        state: The newest state, shape (states,); q, qd, lengths and tensions are parts of it.
        q, qd: Shape (n,), in [rad] or [m], and per [s].
        lengths: l, shape (m,), in [m]; computed where they are not measured.
        tensions: Shape (m,), in [N]; shape (0,) where they are not measured.
        age: Time since the newest state was received, in [s].
        missed: Number of exchanges that brought no new state.
        round_trip: Of the newest answer, in [s]; 0 before the first.
        lateness: How late the newest exchange began, in [s].
        mode: STARTING, RUNNING, HOLDING or STOPPED.
    """

    def __init__(
        self,
        robot: Robot,
        settings: HardwareSettings,
        link: HardwareLink,
        hello: Hello,
        make_recorder: Callable[[], Recorder] | None = None,
        clock: Clock = time,
    ) -> None:
        n, m = len(robot.coordinates), len(robot.muscles)
        self._robot = robot
        self._settings, self._link, self._hello = settings, link, hello
        self._make_recorder = make_recorder
        self._recorder: Recorder | None = None
        self._guard = Guard(robot, settings.safety)
        self._motors = MotorMap(settings.motors, [muscle.name for muscle in robot.muscles])
        self._paths = MusclePaths(robot)
        self._clock = clock
        self._pacer = Pacer(hello.step, clock=clock.monotonic, sleep=clock.sleep)
        self._priority = ExitStack()
        self.state: FloatArray = np.zeros(hello.states)
        lengths = m if settings.has_lengths else 0
        self.q, self.qd, measured, self.tensions = np.split(self.state, [n, 2 * n, 2 * n + lengths])
        self.lengths: FloatArray = measured if settings.has_lengths else np.zeros(m)
        self.age = self.lateness = self.round_trip = 0.0
        self.missed = self._missed_in_a_row = 0
        self.mode = STARTING
        self._rest = self._guard.f_min
        self._time = self._opened = 0.0
        self._ended = False

    @property
    def step(self) -> float:
        """Time between two exchanges, in [s]."""
        return self._hello.step

    def open(self) -> None:
        """Agree with the hardware, and learn where it is.

        Raises:
            HardwareError: It does not answer, or refuses.
            InputError: The recording cannot be written.
        """
        self._link.open(self._hello)
        self._opened = self._clock.monotonic()
        self._take(self._link.start_state)
        self._rest = holding_forces(self._robot, self.q)
        if self._make_recorder is not None:
            self._recorder = self._make_recorder()

    def require_near(self, q: FloatArray) -> None:
        """Refuse to start far from q, shape (n,); see `Guard.require_near`."""
        self._guard.require_near(self.q, q)
        self._guard.check(self.q, self.tensions)

    def exchange(self, t: float, wanted: FloatArray) -> None:
        """Wait for time t, give the forces wanted as far as is safe, take the newest state.

        Args:
            t: In [s].
            wanted: Shape (m,), in [N].

        Raises:
            HardwareError: The run cannot go on; the hardware has been stopped.
        """
        try:
            self._exchange(t, wanted)
        except HardwareError:
            self.end(ramp=False)
            raise
        except BaseException:
            self.end()
            raise

    def end(self, *, ramp: bool = True) -> None:
        """Lead the hardware to its safe state; once, and within a bounded time.

        Args:
            ramp: Whether forces fall slowly before.
        """
        if self._ended:
            return
        self._ended = True
        with ignoring_interrupts():
            try:
                if ramp and self.mode in (RUNNING, HOLDING):
                    self._ramp_down()
            finally:
                self.mode = STOPPED
                self._close()

    def _exchange(self, t: float, wanted: FloatArray) -> None:
        if self._ended:
            raise HardwareError("the hardware has been stopped: a reset connects to it again")
        if self.mode == STARTING:
            self._start(t)
        self._time = t
        if self._settings.is_paced:
            self.lateness = self._pacer.wait(t)
        came = self._send(t, self._guard.admit(t, self.step, wanted), self._deadline())
        self._judge(came)
        self._guard.check(self.q, self.tensions)

    def _start(self, t: float) -> None:
        self._guard.start(t, self._rest)
        self._motors.calibrate(self.lengths, self._rates(), self._guard.forces)
        if self._settings.goes_by_clock:
            self._priority.enter_context(real_time_priority())
        self.mode = RUNNING

    def _deadline(self) -> float:
        """Until when an answer is waited for, on the monotonic clock."""
        patience = _ANSWER * self.step if self._settings.is_paced else self._settings.timeout
        return self._clock.monotonic() + patience

    def _send(self, t: float, forces: FloatArray, deadline: float) -> Exchange:
        command = forces
        if self._settings.motors.command != "force":
            command = self._motors.commands(
                forces, self.lengths, self._rates(), self.tensions, self.step
            )
        came = self._link.exchange(t, command, deadline)
        if self._recorder is not None:
            self._recorder.write(t, command, came)
        if came.state is not None:
            self._take(came.state)
        return came

    def _judge(self, came: Exchange) -> None:
        """Whether the run can go on after an exchange.

        Raises:
            HardwareError: It cannot.
        """
        self.age = min(came.age, self._clock.monotonic() - self._opened)
        if not np.isnan(came.round_trip):
            self.round_trip = came.round_trip
        if came.state is not None and came.device_flags & Flag.FAULT:
            raise HardwareError("the robot behind the device has failed; see the device's messages")
        if came.state is not None and came.device_flags & Flag.SAFE:
            what = f"no command came for {self._hello.watchdog:g} s, or someone stopped it"
            raise HardwareError(f"the device has gone to its safe state: {what}")
        if came.state is not None:
            self._missed_in_a_row, self.mode = 0, RUNNING
            return
        self.missed += 1
        self._missed_in_a_row += 1
        self.mode = HOLDING
        if not self._settings.is_paced:
            what = f"no answer within {self._settings.timeout:g} s, in lock step"
            raise HardwareError(f"the hardware is lost: {what}")
        if self._missed_in_a_row > self._settings.max_missed:
            newest = f"the newest is {came.age:.3g} s old" if came.seq else "none came at all"
            raise HardwareError(
                f"the hardware is lost: no state in {self._missed_in_a_row} exchanges, {newest}; "
                f"hardware.max_missed is {self._settings.max_missed}"
            )

    def _ramp_down(self) -> None:
        """Give forces that fall to f_min, for as long as a run would go on, too."""
        patience = self._settings.max_missed if self._settings.is_paced else 0
        end = self._clock.monotonic() + self._settings.safety.ramp_down + _SPARE
        t, lost = self._time, 0
        with suppress(CardsflowError, OSError):
            for forces in self._guard.ramp_down(self.step):
                t += self.step
                if self._settings.is_paced:
                    self._pacer.wait(t)
                came = self._send(t, forces, min(self._deadline(), end))
                lost = 0 if came.state is not None else lost + 1
                if lost > patience or self._clock.monotonic() > end:
                    return

    def _close(self) -> None:
        with ExitStack() as closing:
            closing.callback(self._priority.close)
            if self._recorder is not None:
                closing.callback(self._recorder.close)
            closing.callback(self._link.close)
            self._link.stop()

    def _take(self, state: FloatArray) -> None:
        self.state[:] = state
        if not self._settings.has_lengths:
            self.lengths[:] = self._paths.evaluate(self.q).lengths

    def _rates(self) -> FloatArray:
        """The rates l' = L qd, shape (m,), in [m/s]."""
        rates: FloatArray = self._paths.evaluate(self.q).jacobian @ self.qd
        return rates
