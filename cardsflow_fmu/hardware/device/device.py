"""The device's side of the protocol: its states, its peer, its watchdog.

It has neither sockets nor clocks: frames, peers and times are arguments.
"""

from __future__ import annotations

import math
import secrets
from collections import Counter, deque
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
)
from cardsflow_fmu.hardware.protocol.handshake import HELLO_VALUES, ErrorCode, Handshake, halves
from cardsflow_fmu.utils.arrays import FloatArray

from .capabilities import Capabilities, bounds

State = Literal["idle", "ready", "running", "safe"]

PEER_TIMEOUT = 1.0
"""A run at rest without a new set point for longer may be taken over by another peer, in [s]."""

_REMEMBERED = 256
"""Numbers of runs by which a device knows copies of their HELLO."""

_LOCKSTEP, _SAFE, _FAULT, _CLAMPED = map(int, (Flag.LOCKSTEP, Flag.SAFE, Flag.FAULT, Flag.CLAMPED))
_HELLO, _SETPOINT, _STATE = (
    Kind.HELLO,
    Kind.SETPOINT,
    Kind.STATE,
)
_FOR_DEVICES = frozenset((_HELLO, _SETPOINT, Kind.STOP, Kind.PING))


class DeviceRobot(Protocol):
    """The robot behind a device.

    Attributes:
        commands: Number of values of a command.
        states: Number of values of a state.
    """

    commands: int
    states: int

    def apply(self, command: FloatArray) -> None:
        """Take the newest commands, shape (commands,), within bounds; to be copied if kept."""

    def advance(self, dt: float) -> None:
        """Advance by dt, in [s]; hardware, which moves by itself, does nothing."""

    def state(self) -> FloatArray:
        """q, qd, l and tension, shape (states,)."""

    def safe(self) -> None:
        """Go to the safe state: least tensions, brakes."""

    def reset(self) -> None:
        """Prepare for a new run; a simulated robot goes to its start state."""


class Device:
    """A device: answers frames, and commands its robot for one peer at a time.

    The states: "idle" before any run, "ready" when a run is agreed on and nothing may move yet,
    "running" from the first set point on, "safe" after a stop, a watchdog timeout or a fault. Only
    a new run leaves "safe".

    Args:
        robot: The robot.
        signature: Hash of its signals; see `signature.port_signature`.
        step: Its own step, in [s].
        scale: A value in a frame is the SI value divided by this.
        key: The pre-shared key; with one, unsigned frames are dropped.
        watchdog: Longest time without a set point while running, in [s]; a link may request less.
        f_min, f_max: Bounds of the commands, numbers or shape (commands,), in SI units.

    Raises:
        InputError: A value is out of range.

    Attributes:
        state: One of the four.
        agreed: Parameters of the present run; None before any.
        failure: Error of the robot; empty while it works. The first set point of another run, which
            nobody can copy, clears it; a HELLO does not.
        counters: Frames received, and frames dropped by reason.
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
        self._run_id = self._nonce = self._seq = 0
        self._begun: deque[int] = deque(maxlen=_REMEMBERED)
        self._has_failed = False
        self._time = 0.0
        self._last_heard = -math.inf
        self._answer = b""
        self._command = np.zeros(robot.commands)
        self._writer = FrameWriter(robot.states)
        robot.safe()

    @property
    def run_id(self) -> int:
        """Number of the present run, 0 before any."""
        return self._run_id

    @property
    def is_signed(self) -> bool:
        """Whether it has a key, and drops what is not signed with it."""
        return self._keys.pre_shared is not None

    @property
    def goes_by_clock(self) -> bool:
        """Whether the robot moves in real time: not in lockstep, nor before a set point."""
        moving = self.state == "running" or self.state == "safe"
        return moving and self.agreed is not None and not self.agreed.lockstep

    @property
    def next_deadline(self) -> float:
        """When the watchdog expires if nothing comes, in [s]; infinite if it is off."""
        if self.state != "running" or self.agreed is None or self.agreed.lockstep:
            return math.inf
        return self._last_heard + self.agreed.watchdog

    def receive(self, data: bytes, peer: Hashable, now: float) -> list[bytes]:
        """Process a frame; returns the answers, for the same peer.

        Args:
            data: The bytes received.
            peer: Their sender.
            now: In [s], on a clock that does not jump.
        """
        self.tick(now)
        self.counters["received"] += 1
        try:
            frame = self._keys.unpack(data)
        except FrameError as error:
            return self._drop(error.reason)
        if frame.kind not in _FOR_DEVICES:
            return self._drop("type")
        if frame.kind is _HELLO:
            return self._answer_hello(frame, peer, now)
        if frame.run_id != self._run_id or self.state == "idle":
            return self._drop("run")
        if peer != self._peer:
            return self._drop("peer")
        if frame.kind is _SETPOINT:
            return self._answer_setpoint(frame, now)
        if frame.kind is Kind.STOP:
            return self._stop(frame, now)
        return [self._reply(Kind.PONG, frame, now, frame.values)]

    def tick(self, now: float) -> None:
        """Check the watchdog at a time, in [s]."""
        if self.state == "running" and now > self.next_deadline:
            self.counters["watchdog"] += 1
            self.go_safe()

    def advance(self, dt: float) -> None:
        """Advance the robot by dt, in [s], if it moves in real time."""
        if self.goes_by_clock:
            self._advance(dt)

    def go_safe(self) -> None:
        """Go to the safe state: on a watchdog timeout, on STOP, at the end of serving."""
        self.state = "safe"
        try:
            self.robot.safe()
        except CardsflowError as error:
            self._note_failure(str(error))

    def _drop(self, reason: str) -> list[bytes]:
        self.counters[reason] += 1
        return []

    def _answer_hello(self, frame: Frame, peer: Hashable, now: float) -> list[bytes]:
        """Agree on a run, or reject it."""
        if frame.run_id == 0:
            return self._drop("run")
        request = Handshake.of_values(np.asarray(frame.values), bool(frame.flags & _LOCKSTEP))
        if request is None or len(frame.values) != HELLO_VALUES:
            return self._drop("hello")
        known = frame.run_id == self._run_id and peer == self._peer
        if known and self.state != "ready" and not self._has_failed:
            return self._drop("stale")  # late, or a copy: the run is under way or over
        if not known:
            is_copy = frame.run_id in self._begun
            refusal: ErrorCode | None = ErrorCode.BUSY
            if self._is_free(peer, now, is_copy=is_copy):
                refusal = self._capabilities.refusal(request)
            if refusal is not None:
                return self._refuse(refusal, frame, now)
            self._begin(request, frame.run_id, peer)
            # a copy, maybe by someone without the key, keeps nobody waiting
            self._last_heard = -math.inf if is_copy else now
        state = self._read_state()
        if self.agreed is None or state is None or self._has_failed:
            return self._refuse(ErrorCode.FAULT, frame, now)
        values = [*self.agreed.values(), *halves(self._nonce), *state]
        return [self._reply(Kind.HELLO_ACK, frame, now, values)]

    def _is_free(self, peer: Hashable, now: float, *, is_copy: bool) -> bool:
        """Return whether a new run may begin: never under one that moves the robot in real time."""
        if self.state == "idle" or self.state == "safe" or self.agreed is None:
            return True
        if self.state == "ready" and peer == self._peer:
            return True
        at_rest = self.state == "ready" or self.agreed.lockstep
        return at_rest and not is_copy and now > self._last_heard + PEER_TIMEOUT

    def _begin(self, request: Handshake, run_id: int, peer: Hashable) -> None:
        self.agreed = self._capabilities.agreed(request)
        self._run_id, self._peer = run_id, peer
        self._nonce = secrets.randbits(64)
        self._keys = self._keys.of_run(run_id, self._nonce)
        self._begun.append(run_id)
        self._seq, self._time, self._answer = 0, 0.0, b""
        self._has_failed = False
        self.state = "ready"
        self.counters["runs"] += 1
        try:
            self.robot.reset()
        except CardsflowError as error:
            self._fail(str(error))

    def _answer_setpoint(self, frame: Frame, now: float) -> list[bytes]:
        """Apply a set point, if it is new, and answer with the state."""
        assert self.agreed is not None
        lockstep = self.agreed.lockstep
        if len(frame.values) != self.robot.commands:
            return self._drop("count")
        if lockstep and frame.seq == self._seq and self._answer:
            self.counters["repeated"] += 1
            return [self._answer]
        if not is_newer(frame.seq, self._seq):
            return self._drop("stale")
        command = np.asarray(frame.values)  # finite, as all values of frames are
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
        """Apply the clamped command; returns the flag CLAMPED if it was out of bounds."""
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
        """The answer to a set point: the robot's state, or the last one known if it has failed."""
        state = self._read_state()
        if state is not None:
            self._writer.values[:] = state
        return self._writer.pack(
            _STATE,
            flags | self._flags(),
            self._run_id,
            frame.seq,
            self._time,
            int(now * 1e9),
            frame.t_send_ns,
            self._keys.of(_STATE),
            are_finite=True,
        )

    def _read_state(self) -> FloatArray | None:
        """The robot's state, scaled for a frame; None, and a fault, if it has no finite one."""
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

    def _refuse(self, code: ErrorCode, frame: Frame, now: float) -> list[bytes]:
        self.counters[code.name.lower()] += 1
        return [self._reply(Kind.ERROR, frame, now, [code])]

    def _reply(
        self, kind: Kind, to: Frame, now: float, values: Sequence[float] | FloatArray = ()
    ) -> bytes:
        """Return an answer to a frame."""
        sent = int(now * 1e9)
        answer = Frame(
            kind, self._flags(), to.run_id, to.seq, self._time, sent, to.t_send_ns, values
        )
        return pack(answer, self._keys.of(kind))


def _scaled(values: FloatArray, factor: float) -> FloatArray | None:
    """Return the values times a factor; None if one is not finite."""
    if factor != 1.0:
        with np.errstate(over="ignore"):
            values = values * factor
    return values if all_finite(values) else None
