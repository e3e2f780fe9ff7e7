"""Device side of the protocol: run states, peer and watchdog.

A device uses neither sockets nor clocks: frames, peers and times are arguments.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Hashable, Sequence
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import CardsflowError, InputError
from cardsflow_fmu.hardware.protocol.frame import (
    Flag,
    Frame,
    FrameError,
    FrameWriter,
    Keys,
    Kind,
    all_finite,
    is_newer,
    pack,
    run_id_of,
)
from cardsflow_fmu.hardware.protocol.handshake import (
    HELLO_VALUES,
    ErrorCode,
    Handshake,
    split_uint64,
)
from cardsflow_fmu.utils.arrays import FloatArray

from .capabilities import Capabilities, bounds
from .nonces import Nonces

State = Literal["idle", "ready", "running", "safe"]

PEER_TIMEOUT = 1.0
"""Idle time after which another peer may replace a confirmed run in which the robot does not move,
in [s]."""

_LOCKSTEP, _SAFE, _FAULT, _CLAMPED = map(int, (Flag.LOCKSTEP, Flag.SAFE, Flag.FAULT, Flag.CLAMPED))
_HELLO, _SETPOINT, _STATE = Kind.HELLO, Kind.SETPOINT, Kind.STATE
_DEVICE_KINDS = frozenset((_HELLO, _SETPOINT, Kind.STOP, Kind.PING))


class DeviceRobot(Protocol):
    """Interface of the robot that a device controls."""

    commands: int
    states: int

    def apply(self, command: FloatArray) -> None:
        """Apply the newest commands, shape (commands,), which are within bounds.

        The caller reuses the array; copy it to store it.
        """

    def advance(self, dt: float) -> None:
        """Advance the simulation by dt, in [s]. For real hardware this does nothing."""

    def state(self) -> FloatArray:
        """Return q, qd, l and tension, shape (states,)."""

    def safe(self) -> None:
        """Enter the safe state: minimum tensions, brakes."""

    def reset(self) -> None:
        """Prepare a new run. A simulated robot returns to its start state."""


class Device:
    """Device that answers frames and commands its robot for one peer at a time.

    The states are "idle" before the first run, "ready" after the handshake (the robot does not
    move yet), "running" from the first set point, and "safe" after a stop, a watchdog timeout or a
    fault. Only a new run leaves "safe".

    With a key, a HELLO may be a copy of a recorded frame. Therefore it does not block other HELLOs.
    The next valid frame of its run confirms the run, since it is signed with the key of the run. If
    another HELLO has replaced the run, a PING with the values of the HELLO takes the run back.

    Args:
        signature: Hash of the signals of the robot; see `signature.port_signature`.
        step: Time step of the device, in [s].
        scale: Scale of the values in frames. A value in a frame is the SI value divided by it.
        key: Pre-shared key, or None. With a key, unsigned frames are dropped.
        watchdog: Watchdog timeout: maximum time between set points in a run, in [s]. A link may
            request a shorter time.
        f_min, f_max: Bounds of the commands, numbers or shape (commands,), in SI units.

    Attributes:
        state: "idle", "ready", "running" or "safe".
        run_id: Id of the current run, or 0 before the first run.
        agreed: Parameters of the current run, or None before the first run.
        failure: Error message of the robot, or empty. The first set point of a new run clears it.
            A HELLO does not clear it, since an attacker can replay a HELLO but not a set point.
        counters: Number of received frames, and number of dropped frames by reason.
    """

    def __init__(
        self,
        robot: DeviceRobot,
        signature: int,
        step: float,
        *,
        scale: float = 1.0,
        key: bytes | None = None,
        watchdog: float = 0.02,
        f_min: ArrayLike,
        f_max: ArrayLike,
    ) -> None:
        self._capabilities = Capabilities(
            signature, step, scale, watchdog, robot.commands, robot.states
        )
        self.robot, self.signature, self.step, self.scale = robot, signature, step, scale
        self.watchdog = watchdog
        self._lower = bounds(f_min, robot.commands, "f_min")
        self._upper = bounds(f_max, robot.commands, "f_max")
        if not (self._lower <= self._upper).all():
            raise InputError("a device's f_min must not be above its f_max")
        self.state: State = "idle"
        self.agreed: Handshake | None = None
        self.failure = ""
        self.counters: Counter[str] = Counter()
        self._keys = Keys(key)
        self._peer: Hashable = None
        self.run_id = self._nonce = self._seq = 0
        self._nonces = Nonces()
        self._has_failed = self._is_confirmed = False
        self._time = 0.0
        self._last_heard = -math.inf
        self._answer = b""
        self._command = np.zeros(robot.commands)
        self._writer = FrameWriter(robot.states)
        robot.safe()

    @property
    def is_signed(self) -> bool:
        """Whether the device has a key and drops frames without a valid signature."""
        return self._keys.pre_shared is not None

    @property
    def moves_in_real_time(self) -> bool:
        """Whether the robot currently moves in real time.

        It does not in lockstep and before the first set point.
        """
        moving = self.state == "running" or self.state == "safe"
        return moving and self.agreed is not None and not self.agreed.lockstep

    @property
    def next_deadline(self) -> float:
        """Time at which the watchdog expires, in [s], or infinity if the watchdog is off."""
        if self.state != "running" or self.agreed is None or self.agreed.lockstep:
            return math.inf
        return self._last_heard + self.agreed.watchdog

    def receive(self, data: bytes, peer: Hashable, now: float) -> list[bytes]:
        """Process a frame and return the answers to the same peer.

        Args:
            data: The received bytes.
            peer: Sender of the bytes.
            now: Current time on a monotonic clock, in [s].
        """
        self.tick(now)
        self.counters["received"] += 1
        is_offered = self.state == "ready" and not self._is_confirmed
        keys = self._offered_keys(run_id_of(data), peer) if is_offered else self._keys
        try:
            frame = keys.unpack(data)
        except FrameError as error:
            return self._drop(error.reason)
        if frame.kind not in _DEVICE_KINDS:
            return self._drop("type")
        if frame.kind is _HELLO:
            return self._answer_hello(frame, peer, now)
        if is_offered and frame.kind is Kind.PING:
            self._take_back(frame, peer)
        if frame.run_id != self.run_id or self.state == "idle":
            return self._drop("run")
        if peer != self._peer:
            return self._drop("peer")
        if not self._is_confirmed:
            self._confirm(now)
        if frame.kind is _SETPOINT:
            return self._answer_setpoint(frame, now)
        if frame.kind is Kind.STOP:
            return self._stop(frame, now)
        return [self._reply(Kind.PONG, frame, now, frame.values)]

    def tick(self, now: float) -> None:
        """Check the watchdog at the time `now`, in [s]."""
        if self.state == "running" and now > self.next_deadline:
            self.counters["watchdog"] += 1
            self.go_safe()

    def advance(self, dt: float) -> None:
        """Advance the robot by dt, in [s], if it currently moves in real time."""
        if self.moves_in_real_time:
            self._advance(dt)

    def go_safe(self) -> None:
        """Enter the safe state, after a watchdog timeout, a STOP, or when the server ends."""
        self.state = "safe"
        try:
            self.robot.safe()
        except CardsflowError as error:
            self._note_failure(str(error))

    def _drop(self, reason: str) -> list[bytes]:
        self.counters[reason] += 1
        return []

    def _answer_hello(self, frame: Frame, peer: Hashable, now: float) -> list[bytes]:
        """Accept or reject a requested run."""
        if frame.run_id == 0:
            return self._drop("run")
        request = Handshake.from_values(np.asarray(frame.values), bool(frame.flags & _LOCKSTEP))
        if request is None or len(frame.values) != HELLO_VALUES:
            return self._drop("hello")
        is_current_run = frame.run_id == self.run_id and peer == self._peer
        if is_current_run and self.state != "ready" and not self._has_failed:
            return self._drop("stale")  # a late frame or a copy: the run has already begun
        if not is_current_run:
            rejection: ErrorCode | None = ErrorCode.BUSY
            if self._is_free(peer, now):
                rejection = self._capabilities.rejection(request)
            if rejection is not None:
                return self._reject(rejection, frame, now)
            self._begin(request, frame.run_id, peer)
            if not self.is_signed:
                self._confirm(now)
        state = self._read_state()
        if self.agreed is None or state is None or self._has_failed:
            return self._reject(ErrorCode.FAULT, frame, now)
        values = [*self.agreed.values(), *split_uint64(self._nonce), *state]
        return [self._reply(Kind.HELLO_ACK, frame, now, values)]

    def _is_free(self, peer: Hashable, now: float) -> bool:
        """Return whether a new run may begin.

        A new run never replaces a run in which the robot moves in real time.
        """
        if self.state == "idle" or self.state == "safe" or self.agreed is None:
            return True
        if self.state == "ready" and peer == self._peer and not self.is_signed:
            return True
        at_rest = self.state == "ready" or self.agreed.lockstep
        is_silent = not self._is_confirmed or now > self._last_heard + PEER_TIMEOUT
        return at_rest and is_silent

    def _confirm(self, now: float) -> None:
        """Reserve the device for the current run. The nonces of all offered runs expire."""
        self._is_confirmed, self._last_heard = True, now
        self._nonces.renew()

    def _offered_keys(self, run_id: int, peer: Hashable) -> Keys:
        """Return the keys of a run that the device has offered and may have replaced."""
        return self._keys.for_run(run_id, self._nonces.nonce(run_id, peer))

    def _take_back(self, ping: Frame, peer: Hashable) -> None:
        """Begin the run of a PING again if another HELLO has replaced it."""
        if ping.run_id == self.run_id and peer == self._peer:
            return
        request = Handshake.from_values(ping.values, bool(ping.flags & _LOCKSTEP))
        if request is not None and self._capabilities.rejection(request) is None:
            self._begin(request, ping.run_id, peer)

    def _begin(self, request: Handshake, run_id: int, peer: Hashable) -> None:
        self.agreed = self._capabilities.run_parameters(request)
        self.run_id, self._peer = run_id, peer
        self._nonce = self._nonces.nonce(run_id, peer)
        self._keys = self._keys.for_run(run_id, self._nonce)
        self._seq, self._time, self._answer = 0, 0.0, b""
        self._has_failed = self._is_confirmed = False
        self.state = "ready"
        self.counters["runs"] += 1
        try:
            self.robot.reset()
        except CardsflowError as error:
            self._fail(str(error))

    def _answer_setpoint(self, frame: Frame, now: float) -> list[bytes]:
        """Apply a set point if it is new, and answer with the state."""
        assert self.agreed is not None
        lockstep = self.agreed.lockstep
        if len(frame.values) != self.robot.commands:
            return self._drop("count")
        if lockstep and frame.seq == self._seq and self._answer:
            self.counters["repeated"] += 1
            return [self._answer]
        if not is_newer(frame.seq, self._seq):
            return self._drop("stale")
        command = np.asarray(frame.values)  # `unpack` has rejected frames that are not finite
        if self.scale != 1.0:
            scaled = _scaled(command, self.scale)
            if scaled is None:
                return self._drop("not finite")
            command = scaled
        self._seq = frame.seq
        flags = 0
        if self.state != "safe":
            self._last_heard = now
            if self.state == "ready":
                self.failure = ""
            self.state = "running"
            flags = self._command_robot(command)
            if lockstep:
                self._advance(self.agreed.step)
        self.counters["setpoints"] += 1
        self._answer = self._state_frame(frame, flags, now)
        return [self._answer]

    def _command_robot(self, command: FloatArray) -> int:
        """Apply the clamped command. Return the flag CLAMPED if the command was out of bounds."""
        within = self._command
        np.maximum(command, self._lower, out=within)
        np.minimum(within, self._upper, out=within)
        clamped = within.tolist() != command.tolist()
        if clamped:
            self.counters["clamped"] += 1
        try:
            self.robot.apply(within)
        except CardsflowError as error:
            self._fail(str(error))
        return _CLAMPED if clamped else 0

    def _advance(self, dt: float) -> None:
        try:
            self.robot.advance(dt)
        except CardsflowError as error:
            self._fail(str(error))
        self._time += dt

    def _state_frame(self, frame: Frame, flags: int, now: float) -> bytes:
        """Return the answer to a set point: the newest state that could be read from the robot."""
        state = self._read_state()
        if state is not None:
            self._writer.values[:] = state
        return self._writer.pack(
            _STATE,
            flags | self._flags(),
            self.run_id,
            frame.seq,
            self._time,
            int(now * 1e9),
            frame.t_send_ns,
            self._keys.key_for(_STATE),
            are_finite=True,
        )

    def _read_state(self) -> FloatArray | None:
        """Return the robot's state, scaled for a frame.

        If the state cannot be read or is not finite, report a fault and return None.
        """
        try:
            state = _scaled(self.robot.state(), 1 / self.scale)
        except CardsflowError as error:
            self._fail(str(error))
            return None
        if state is None:
            self._fail("the robot's state is not finite")
        return state

    def _stop(self, frame: Frame, now: float) -> list[bytes]:
        self.go_safe()
        self.counters["stops"] += 1
        return [self._reply(Kind.STOPPED, frame, now)]

    def _fail(self, why: str) -> None:
        self.counters["faults"] += 1
        self._note_failure(why)
        self.go_safe()

    def _note_failure(self, why: str) -> None:
        self.failure = self.failure if self._has_failed and self.failure else why
        self._has_failed = True

    def _flags(self) -> int:
        flags = _LOCKSTEP if self.agreed is not None and self.agreed.lockstep else 0
        if self.state == "safe":
            flags |= _SAFE
        return flags | _FAULT if self._has_failed else flags

    def _reject(self, code: ErrorCode, frame: Frame, now: float) -> list[bytes]:
        self.counters[code.name.lower()] += 1
        return [self._reply(Kind.ERROR, frame, now, [code])]

    def _reply(
        self, kind: Kind, to: Frame, now: float, values: Sequence[float] | FloatArray = ()
    ) -> bytes:
        sent = int(now * 1e9)
        answer = Frame(
            kind, self._flags(), to.run_id, to.seq, self._time, sent, to.t_send_ns, values
        )
        return pack(answer, self._keys.key_for(kind))


def _scaled(values: FloatArray, factor: float) -> FloatArray | None:
    """Return the values multiplied by a factor, or None if a result is not finite."""
    if factor != 1.0:
        with np.errstate(over="ignore"):
            values = values * factor
    return values if all_finite(values) else None
