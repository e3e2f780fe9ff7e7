"""A device's side of the protocol: who may command the robot, when, and what happens in silence.

It knows neither sockets nor clocks: whoever serves it says what came, from whom, and when.
"""

from __future__ import annotations

import math
import secrets
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
)
from cardsflow_fmu.hardware.protocol.handshake import HELLO_VALUES, ErrorCode, Hello, halves
from cardsflow_fmu.utils.arrays import FloatArray

from .capabilities import Offer, bounds

State = Literal["idle", "ready", "running", "safe"]

PATIENCE = 1.0
"""A run at rest whose sender has been silent for so long may be taken by another, in [s]."""

_LOCKSTEP, _SAFE, _FAULT, _CLAMPED = map(int, (Flag.LOCKSTEP, Flag.SAFE, Flag.FAULT, Flag.CLAMPED))
_HELLO, _SETPOINT, _STATE = Kind.HELLO, Kind.SETPOINT, Kind.STATE  # found sooner, for each frame
_FOR_DEVICES = frozenset((_HELLO, _SETPOINT, Kind.STOP, Kind.PING))


class DeviceRobot(Protocol):
    """What is behind a device.

    Attributes:
        commands: Number of values of a command.
        states: Number of values of a state.
    """

    commands: int
    states: int

    def apply(self, command: FloatArray) -> None:
        """Take the newest commands, shape (commands,), within bounds; to be copied if kept."""

    def advance(self, dt: float) -> None:
        """Go on by dt, in [s]; hardware, which goes by itself, does nothing."""

    def state(self) -> FloatArray:
        """q, qd, l and tension, shape (states,)."""

    def safe(self) -> None:
        """Go to the safe state: least tensions, brakes."""

    def reset(self) -> None:
        """Be ready for a new run; what is simulated goes to its start state."""


class Device:
    """Takes frames and answers them; commands the robot for one sender at a time.

    The states: "idle" before any run, "ready" when a run is agreed on and nothing may move yet,
    "running" from the first set point on, "safe" when it was stopped, in silence, or after a fault.
    From "safe" a new run leads on, and nothing else.

    Args:
        robot: What is commanded.
        signature: Hash of its signals; see `signature.port_signature`.
        step: Its own step, in [s].
        scale: A value in a frame is the SI value divided by this.
        key: The pre-shared key; with one, frames that are not signed are not heard.
        watchdog: Longest silence while running, in [s]; a link may ask for a shorter one.
        f_min, f_max: Bounds of the commands, numbers or shape (commands,), in SI units.

    Raises:
        InputError: A value is out of range.

    Attributes:
        state: One of the four.
        agreed: What the present run is like; None before any.
        failure: What the robot failed of; empty while it works.
        counters: What came, and what was dropped for what reason.
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
        self._offer = Offer(signature, step, scale, watchdog, robot.commands, robot.states)
        self.robot, self.signature, self.step, self.scale = robot, signature, step, scale
        self.watchdog = watchdog
        self._lower = bounds(f_min, robot.commands, "f_min")
        self._upper = bounds(f_max, robot.commands, "f_max")
        if not (self._lower <= self._upper).all():
            raise InputError("a device's f_min must not be above its f_max")
        self.state: State = "idle"
        self.agreed: Hello | None = None
        self.failure = ""
        self.counters: Counter[str] = Counter()
        self._keys = Keys(key)
        self._peer: Hashable = None
        self._run_id = self._nonce = self._seq = 0
        self._time = 0.0
        self._heard = -math.inf
        self._answer = b""
        self._command = np.zeros(robot.commands)
        self._writer = FrameWriter(robot.states)
        robot.safe()

    @property
    def run_id(self) -> int:
        """Number of the present run, 0 before any."""
        return self._run_id

    @property
    def goes_by_clock(self) -> bool:
        """Whether time moves the robot: not in lock step, nor before a run's first set point."""
        moving = self.state == "running" or self.state == "safe"
        return moving and self.agreed is not None and not self.agreed.lockstep

    @property
    def next_deadline(self) -> float:
        """When the watchdog bites if nothing comes, in [s]; infinite if it sleeps."""
        if self.state != "running" or self.agreed is None or self.agreed.lockstep:
            return math.inf
        return self._heard + self.agreed.watchdog

    def receive(self, data: bytes, peer: Hashable, now: float) -> list[bytes]:
        """Take a frame; returns the answers, for the same peer.

        Args:
            data: Whatever came.
            peer: Who sent it.
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
            return self._greet(frame, peer, now)
        if frame.run_id != self._run_id or self.state == "idle":
            return self._drop("run")
        if peer != self._peer:
            return self._drop("peer")
        if frame.kind is _SETPOINT:
            return self._follow(frame, now)
        if frame.kind is Kind.STOP:
            return self._stop(frame, now)
        return [self._say(Kind.PONG, frame, now, frame.values)]

    def tick(self, now: float) -> None:
        """Let the watchdog look at the clock, in [s]."""
        if self.state == "running" and now > self.next_deadline:
            self.counters["watchdog"] += 1
            self.go_safe()

    def advance(self, dt: float) -> None:
        """Let the robot go on by dt, in [s], by the clock; in lock step set points alone do that.

        It holds still until a run moves it.
        """
        if self.goes_by_clock:
            self._advance(dt)

    def go_safe(self) -> None:
        """Go to the safe state: when the watchdog bites, when asked to, when no more is served."""
        self.state = "safe"
        try:
            self.robot.safe()
        except CardsflowError as error:
            self.failure = self.failure or str(error)

    def _drop(self, reason: str) -> list[bytes]:
        self.counters[reason] += 1
        return []

    def _greet(self, frame: Frame, peer: Hashable, now: float) -> list[bytes]:
        """Agree on a run, or say why not."""
        if frame.run_id == 0:
            return self._drop("run")
        wish = Hello.of_values(np.asarray(frame.values), bool(frame.flags & _LOCKSTEP))
        if wish is None or len(frame.values) != HELLO_VALUES:
            return self._drop("hello")
        known = frame.run_id == self._run_id and peer == self._peer
        if known and self.state != "ready" and not self.failure:
            return self._drop("stale")  # late, or a copy: the run is under way or over
        if not known:
            refusal = self._offer.objection(wish) if self._is_free(peer, now) else ErrorCode.BUSY
            if refusal is not None:
                return self._refuse(refusal, frame, now)
            self._begin(wish, frame.run_id, peer)
        self._heard = now
        state = self._read_state()
        if self.agreed is None or state is None or self.failure:
            return self._refuse(ErrorCode.FAULT, frame, now)
        values = [*self.agreed.values(), *halves(self._nonce), *state]
        return [self._say(Kind.HELLO_ACK, frame, now, values)]

    def _is_free(self, peer: Hashable, now: float) -> bool:
        """Whether a new run may begin: never under one that moves the robot by the clock."""
        if self.state == "idle" or self.state == "safe" or self.agreed is None:
            return True
        if self.state == "ready" and peer == self._peer:
            return True
        at_rest = self.state == "ready" or self.agreed.lockstep
        return at_rest and now > self._heard + PATIENCE

    def _begin(self, wish: Hello, run_id: int, peer: Hashable) -> None:
        self.agreed = self._offer.agreed(wish)
        self._run_id, self._peer = run_id, peer
        self._nonce = secrets.randbits(64)
        self._keys = self._keys.of_run(run_id, self._nonce)
        self._seq, self._time, self._answer = 0, 0.0, b""
        self.failure = ""
        self.state = "ready"
        self.counters["runs"] += 1
        try:
            self.robot.reset()
        except CardsflowError as error:
            self._fail(str(error))

    def _follow(self, frame: Frame, now: float) -> list[bytes]:
        """Do what a set point says, if it is news, and answer with the state."""
        assert self.agreed is not None
        lockstep = self.agreed.lockstep
        if len(frame.values) != self.robot.commands:
            return self._drop("count")
        if lockstep and frame.seq == self._seq and self._answer:
            self._heard = now
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
            self._heard = now
            self.state = "running"
            flags = self._command_robot(command)
            if lockstep:
                self._advance(self.agreed.step)
        self.counters["setpoints"] += 1
        self._answer = self._tell(frame, flags, now)
        return [self._answer]

    def _command_robot(self, command: FloatArray) -> int:
        """Give the robot commands within bounds; returns the flag that says if they were not."""
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

    def _tell(self, frame: Frame, flags: int, now: float) -> bytes:
        """The robot's state in answer to a set point; the last one known if it has failed."""
        state = self._read_state()
        if state is not None:
            self._writer.values[:] = state
        return self._writer.pack_finite(
            _STATE,
            flags | self._flags(),
            self._run_id,
            frame.seq,
            self._time,
            int(now * 1e9),
            frame.t_send_ns,
            self._keys.of(_STATE),
        )

    def _read_state(self) -> FloatArray | None:
        """The robot's state as frames have it; None if it has none to tell, which is a fault."""
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
        return [self._say(Kind.STOPPED, frame, now)]

    def _fail(self, why: str) -> None:
        self.counters["faults"] += 1
        self.failure = self.failure or why
        self.go_safe()

    def _flags(self) -> int:
        flags = _LOCKSTEP if self.agreed is not None and self.agreed.lockstep else 0
        if self.state == "safe":
            flags |= _SAFE
        return flags | _FAULT if self.failure else flags

    def _refuse(self, code: ErrorCode, frame: Frame, now: float) -> list[bytes]:
        self.counters[code.name.lower()] += 1
        return [self._say(Kind.ERROR, frame, now, [code])]

    def _say(
        self, kind: Kind, to: Frame, now: float, values: Sequence[float] | FloatArray = ()
    ) -> bytes:
        """An answer to a frame."""
        sent = int(now * 1e9)
        answer = Frame(
            kind, self._flags(), to.run_id, to.seq, self._time, sent, to.t_send_ns, values
        )
        return pack(answer, self._keys.of(kind))


def _scaled(values: FloatArray, factor: float) -> FloatArray | None:
    """The values times a factor; None if one is not finite."""
    if factor != 1.0:
        with np.errstate(over="ignore"):
            values = values * factor
    return values if all_finite(values) else None
