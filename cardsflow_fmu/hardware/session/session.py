"""Session with hardware: limits desired forces, sends commands and receives states."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack, suppress

import numpy as np

from addin_sdfusion.robot import CardsflowError, Robot
from cardsflow_fmu.cosim.pacing import Pacer, real_time_priority
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.hardware.links.link import HardwareLink
from cardsflow_fmu.hardware.protocol.clock import Clock
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.exchange import Exchange
from cardsflow_fmu.hardware.protocol.frame import Flag
from cardsflow_fmu.hardware.protocol.handshake import Handshake
from cardsflow_fmu.hardware.protocol.recording import Recorder
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.interrupts import ignore_interrupts
from controllers.force_distribution.gravity_compensation import gravity_compensation
from sim_dart import MusclePaths, control_dynamics
from sim_dart.estimation.fitted_pose import FittedPose

from .motors import MotorMap
from .safety import Guard

STARTING, RUNNING, HOLDING, STOPPED = range(4)

_ANSWER_FRACTION = 0.6
"""Fraction of a step for the wait for an answer. The controller uses the remaining time."""
_MAX_STATE_AGE = 2.0
"""Maximum age of the state on which control begins, in steps."""
_MAX_RAMP_DELAY = 0.5
"""Maximum time by which a ramp down in real time may take longer than specified, in [s]."""


class HardwareSession:
    """Run with hardware, which always ends in the safe state.

    Args:
        link: Link to the hardware, which is not open yet.
        make_recorder: Function that creates the recorder after the link is open, or None for no
            recording.
        pose: Pose fit to the muscle lengths for robots without measured positions, or None.

    Attributes:
        state: Newest state, shape (states,), with all measured values.
        q, qd: Positions and velocities, shape (n,), in [rad] or [m], and per [s]. If positions are
            not measured, q is the pose that best fits the lengths, and qd is 0.
        lengths: Muscle lengths l, shape (m,), in [m]; computed from q if not measured.
        tensions: Tensions, shape (m,), in [N], or shape (0,) if not measured.
        torques: Torques of joint motors, in [N·m] or [N], or shape (0,) if not measured.
        age: Time since the newest state arrived, in [s].
        missed: Number of exchanges without a new state.
        clamped: Number of commands that the device clamped to its limits.
        round_trip: Round trip time of the newest answer, in [s]; 0 before the first answer.
        lateness: Delay of the start of the newest exchange, in [s].
        mode: STARTING, RUNNING, HOLDING or STOPPED.
    """

    def __init__(
        self,
        robot: Robot,
        settings: HardwareSettings,
        link: HardwareLink,
        handshake: Handshake,
        make_recorder: Callable[[], Recorder] | None = None,
        clock: Clock = time,
        pose: FittedPose | None = None,
    ) -> None:
        n, m = len(robot.coordinates), len(robot.muscles)
        self._robot = robot
        self._settings, self._link, self._handshake = settings, link, handshake
        self._make_recorder = make_recorder
        self._recorder: Recorder | None = None
        self._guard = Guard(robot, settings)
        self._motors = MotorMap(settings.motors, [muscle.name for muscle in robot.muscles])
        self._paths = MusclePaths(robot)
        self._clock = clock
        self._pacer = Pacer(handshake.step, clock=clock.monotonic, sleep=clock.sleep)
        self._priority = ExitStack()
        self.state: FloatArray = np.zeros(handshake.states)
        self._m = m
        lengths, tensions = (
            m if measured else 0 for measured in (settings.has_lengths, settings.has_tensions)
        )
        encoders, self._pose = n if pose is None else 0, pose
        ends = np.cumsum([encoders, encoders, lengths, tensions])
        self.q, self.qd, measured, self.tensions, self.torques = np.split(self.state, ends)
        if pose is not None:
            self.q, self.qd = pose.q, np.zeros(n)
        self.lengths: FloatArray = measured if settings.has_lengths else np.zeros(m)
        self.age = self.lateness = self.round_trip = 0.0
        self.missed = self.clamped = self._missed_in_a_row = 0
        self.mode = STARTING
        self._rest = self._guard.resting_forces
        self._time = self._opened = self._max_lateness = 0.0
        self._ended = False

    @property
    def step(self) -> float:
        """Time between two exchanges, in [s]."""
        return self._handshake.step

    def open(self) -> None:
        """Connect to the hardware and read its state.

        Raises:
            HardwareError: The hardware does not answer, or rejects the run.
            InputError: The recording cannot be written.
        """
        self._link.open(self._handshake)
        self._opened = self._clock.monotonic()
        self._store(self._link.start_state)
        self._rest = gravity_compensation(control_dynamics(self._robot), self.q)
        if self._make_recorder is not None:
            self._recorder = self._make_recorder()

    def require_near(self, q: FloatArray) -> None:
        """Check that the robot is close to the positions q, shape (n,), and within all limits.

        Raises:
            HardwareError: The robot is too far away or exceeds a limit; see `Guard`.
        """
        self._guard.require_near(self.q, q)
        self._guard.check(self.q, self.tensions)

    def exchange(self, t: float, desired: FloatArray) -> None:
        """Wait for time t, send the limited desired forces, and read the newest state.

        Args:
            t: Time of the run, in [s].
            desired: Forces of the muscles and torques of the motors, shape (a,), in [N] and [N·m].

        Raises:
            HardwareError: The run cannot continue; the hardware has been stopped.
        """
        try:
            self._exchange(t, desired)
        except HardwareError:
            self.end(ramp=False)
            raise
        except BaseException:
            self.end()
            raise

    def end(self, *, ramp: bool = True) -> None:
        """Bring the hardware to its safe state within a bounded time. Further calls do nothing.

        Args:
            ramp: Whether to ramp forces down before.
        """
        if self._ended:
            return
        self._ended = True
        with ignore_interrupts():
            try:
                if ramp and self.mode in (RUNNING, HOLDING):
                    self._ramp_down()
            finally:
                self.mode = STOPPED
                self._close()

    def _exchange(self, t: float, desired: FloatArray) -> None:
        if self._ended:
            raise HardwareError("the hardware has been stopped; reset to connect again")
        if self.mode == STARTING:
            self._wait_for_state(t, self._start(t, desired))
            return
        self._time = t
        if self._settings.is_paced:
            self.lateness = self._pacer.wait(t)
            self._max_lateness = max(self._max_lateness, self.lateness)
        self._exchange_once(t, desired, self._deadline())

    def _wait_for_state(self, t: float, desired: FloatArray) -> None:
        """Repeat the first exchange until the hardware answers, so that control has a new state."""
        self._time = t
        self._exchange_once(t, desired, self._deadline())
        while self._missed_in_a_row:
            self._exchange_once(t, desired, self._clock.monotonic() + self.step)
        if self._settings.is_paced:
            self._pacer.wait(t)

    def _exchange_once(self, t: float, desired: FloatArray, deadline: float) -> None:
        self._check(self._send(t, self._guard.limit(t, self.step, desired), deadline))
        self._guard.check(self.q, self.tensions)

    def _start(self, t: float, desired: FloatArray) -> FloatArray:
        """Start the motion. Return the first forces, which hold the robot if the state is old."""
        self._guard.start(t, self._rest)
        self._motors.calibrate(self.lengths, self._rates(), self._guard.forces[: self._m])
        if self._settings.moves_in_real_time:
            self._priority.enter_context(real_time_priority())
        self.mode = RUNNING
        is_old = self._clock.monotonic() - self._opened > _MAX_STATE_AGE * self.step
        return self._rest if is_old and self._settings.is_paced else desired

    def _deadline(self) -> float:
        """Return the end of the wait for an answer, on the link's clock, in [s]."""
        allowed = (
            _ANSWER_FRACTION * self.step if self._settings.is_paced else self._settings.timeout
        )
        return self._clock.monotonic() + allowed

    def _send(self, t: float, forces: FloatArray, deadline: float) -> Exchange:
        command = forces
        if self._settings.motors.command != "force":
            m = self._m
            muscle_commands = self._motors.commands(
                forces[:m], self.lengths, self._rates(), self.tensions, self.step
            )
            command = np.concatenate([muscle_commands, forces[m:]])
        exchange = self._link.exchange(t, command, deadline)
        if self._recorder is not None:
            self._recorder.write(t, command, exchange)
        if exchange.state is not None:
            self._store(exchange.state)
        return exchange

    def _check(self, exchange: Exchange) -> None:
        """Update the diagnostics after an exchange."""
        self.age = min(exchange.age, self._clock.monotonic() - self._opened)
        if not np.isnan(exchange.round_trip):
            self.round_trip = exchange.round_trip
        if exchange.state is not None and exchange.device_flags & Flag.FAULT:
            raise HardwareError("the robot of the device has failed; see the device's messages")
        if exchange.state is not None and exchange.device_flags & Flag.SAFE:
            agreed = self._link.agreed or self._handshake
            problem = (
                f"no command arrived for {agreed.watchdog:g} s, or it was stopped (this computer "
                f"started steps late by up to {1e3 * self._max_lateness:.3g} ms; see also the "
                "lateness in the messages of the device)"
            )
            raise HardwareError(f"the device has entered its safe state: {problem}")
        if exchange.state is not None:
            self.clamped += bool(exchange.device_flags & Flag.CLAMPED)
            self._missed_in_a_row, self.mode = 0, RUNNING
            return
        self.missed += 1
        self._missed_in_a_row += 1
        self.mode = HOLDING
        if not self._settings.is_paced:
            problem = f"no answer within {self._settings.timeout:g} s in lockstep"
            raise HardwareError(f"the hardware does not respond: {problem}")
        if self._missed_in_a_row > self._settings.max_missed:
            age = f"the newest is {exchange.age:.3g} s old" if exchange.seq else "none before"
            raise HardwareError(
                f"the hardware does not respond: no state in {self._missed_in_a_row} exchanges "
                f"({age}); hardware.max_missed is {self._settings.max_missed}"
            )

    def _ramp_down(self) -> None:
        """Ramp the forces down; stop early if exchanges fail or the ramp takes too long."""
        settings, paced = self._settings, self._settings.is_paced
        allowed, delay = (settings.max_missed, _MAX_RAMP_DELAY) if paced else (0, settings.timeout)
        end = self._clock.monotonic() + settings.ramp_down + delay
        t, lost = self._time, 0
        with suppress(CardsflowError, OSError):
            for forces in self._guard.ramp_down(self.step):
                t += self.step
                if paced:
                    self._pacer.wait(t)
                exchange = self._send(t, forces, min(self._deadline(), end))
                lost = 0 if exchange.state is not None else lost + 1
                if lost > allowed or self._clock.monotonic() > end:
                    return

    def _close(self) -> None:
        with ExitStack() as closing:
            closing.callback(self._priority.close)
            if self._recorder is not None:
                closing.callback(self._recorder.close)
            closing.callback(self._link.close)
            self._link.stop()

    def _store(self, state: FloatArray) -> None:
        self.state[:] = state
        if self._pose is not None:
            self._pose.follow(self.lengths, self.tensions)
        if not self._settings.has_lengths:
            self.lengths[:] = self._paths.evaluate(self.q).lengths

    def _rates(self) -> FloatArray:
        """Return the rates l' = L qd, shape (m,), in [m/s]."""
        rates: FloatArray = self._paths.evaluate(self.q).jacobian @ self.qd
        return rates
