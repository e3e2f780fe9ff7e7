"""Controller side of the protocol, for any transport of frames."""

from __future__ import annotations

import math
import secrets
import time
from abc import ABC, abstractmethod
from collections import Counter
from typing import Self

import numpy as np

from cardsflow_fmu.hardware.protocol.clock import Clock
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.exchange import Exchange
from cardsflow_fmu.hardware.protocol.frame import (
    Flag,
    Frame,
    FrameError,
    FrameWriter,
    Keys,
    Kind,
    is_newer,
    pack,
)
from cardsflow_fmu.hardware.protocol.handshake import (
    ACK_VALUES,
    HELLO_VALUES,
    REJECTION_REASONS,
    ErrorCode,
    Handshake,
    join_uint64,
)
from cardsflow_fmu.utils.arrays import FloatArray

_HELLO_PERIOD = 0.05
_CONFIRMED_TIME = 0.9
"""Time for which no other HELLO replaces a confirmed run, with a margin, in [s]."""
_STOP_PERIOD = 0.02
_MAX_STOPS = 10
_REPEAT_PERIOD = 0.02
"""Time after which an unanswered set point is sent again in lockstep, in [s]."""
_MAX_FRAMES = 1000
"""Maximum number of frames that an exchange reads, so that a flood cannot block it."""
_LOCKSTEP = int(Flag.LOCKSTEP)
_SETPOINT, _STATE = Kind.SETPOINT, Kind.STATE


class FramedLink(ABC):
    """Base class of links with frames. Derived classes send and receive bytes.

    Args:
        uri: Address of the device, used in messages.
        key: Pre-shared key, or None for unsigned frames.
        timeout: Maximum time for which `open` waits, in [s].

    Attributes:
        uri: Address of the device. `HardwareLink` describes the other attributes.
    """

    def __init__(
        self, uri: str, *, key: bytes | None, timeout: float = 2.0, clock: Clock = time
    ) -> None:
        self.uri, self._timeout = uri, timeout
        self.clock = clock
        self.run_id = 0
        self.agreed: Handshake | None = None
        self.start_state: FloatArray = np.zeros(0)
        self.counters: Counter[str] = Counter()
        self._pre_shared = Keys(key)
        self._keys = self._pre_shared
        self._key: bytes | None = None
        self._writer = FrameWriter(0)
        self._seq = self._newest_seq = 0
        self._newest_at = self._confirmed_at = -math.inf
        self._moving = False

    @abstractmethod
    def _connect(self) -> None:
        """Open the transport."""

    @abstractmethod
    def _disconnect(self) -> None:
        """Close the transport. Further calls do nothing."""

    @abstractmethod
    def _send(self, data: bytes) -> None:
        """Send a frame. If it cannot be sent, count it as lost."""

    @abstractmethod
    def _receive(self, deadline: float) -> bytes | None:
        """Return the next frame, or None if no frame arrives before the deadline.

        A frame that has already arrived is returned even after the deadline.

        Args:
            deadline: End of the wait on the link's clock, in [s].
        """

    def open(self, handshake: Handshake) -> None:
        """Start a run by a handshake with the device; see `HardwareLink.open`."""
        self.close()
        self._connect()
        try:
            self._agree(handshake)
        except BaseException:
            self.close()
            raise

    def _agree(self, handshake: Handshake) -> None:
        """Repeat the HELLO, a number of times, so that a pause of this process is no timeout."""
        run_id = secrets.randbelow(0xFFFFFFFF) + 1
        is_busy = False
        for _ in range(math.ceil(self._timeout / _HELLO_PERIOD)):
            flags = _LOCKSTEP if handshake.lockstep else 0
            sent = self.clock.monotonic_ns()
            frame = Frame(Kind.HELLO, flags, run_id, 0, 0.0, sent, 0, handshake.values())
            self._send(pack(frame, self._pre_shared.pre_shared))
            until = self.clock.monotonic() + _HELLO_PERIOD
            while (answer := self._next_frame(self._pre_shared, run_id, until)) is not None:
                if answer.kind is Kind.HELLO_ACK:
                    self._begin(handshake, answer)
                    if self._confirm(handshake):
                        return
                elif answer.kind is Kind.ERROR:
                    is_busy = self._is_busy(answer) or is_busy
        self._raise_not_accepted(is_busy)

    def _confirm(self, handshake: Handshake) -> bool:
        """Confirm the run to a device with a key. Return whether the device answers in time.

        Without a confirmation, the HELLO of anyone, even a recorded one, would replace the run.
        """
        if self._key is None:
            return True
        flags, sent = _LOCKSTEP if handshake.lockstep else 0, self.clock.monotonic_ns()
        ping = Frame(Kind.PING, flags, self.run_id, 0, 0.0, sent, 0, handshake.values())
        self._send(pack(ping, self._key))
        until = self.clock.monotonic() + _HELLO_PERIOD
        while (answer := self._next_frame(self._keys, self.run_id, until)) is not None:
            if answer.kind is Kind.PONG:
                self._confirmed_at = self.clock.monotonic()
                return True
        return False

    def _is_late(self) -> bool:
        """Return whether a HELLO may have replaced the run before its first set point."""
        is_over = self.clock.monotonic() > self._confirmed_at + _CONFIRMED_TIME
        return self._key is not None and is_over

    def _raise_not_accepted(self, is_busy: bool) -> None:
        """Raise the error for a run that the device has not accepted in time."""
        if is_busy:
            raise HardwareError(
                f"the device at {self.uri} rejected the run: {REJECTION_REASONS[ErrorCode.BUSY]}"
            )
        remedy = "is it running, and is the address correct?"
        if self.counters["signature"] or self.counters["unsigned"]:
            remedy = "its frames have a different signature: use the same key file on both sides"
        elif self._pre_shared.pre_shared is not None:
            remedy = "is it running, is the address correct, and does it use the same key?"
        raise HardwareError(
            f"no device answers at {self.uri} within {self._timeout:g} s: {remedy} "
            "(a device with a key ignores frames without a valid signature)"
        )

    def _is_busy(self, answer: Frame) -> bool:
        """Return True if the device is busy, and raise the error for any other rejection."""
        code = int(answer.values[0]) if len(answer.values) else 0
        if code == ErrorCode.BUSY:
            return True
        is_known = code in REJECTION_REASONS
        why = REJECTION_REASONS[ErrorCode(code)] if is_known else f"unknown reason {code}"
        raise HardwareError(f"the device at {self.uri} rejected the run: {why}")

    def _begin(self, handshake: Handshake, answer: Frame) -> None:
        """Start the run that the device has accepted."""
        values = np.asarray(answer.values)
        invalid = f"the device at {self.uri} answered the handshake with invalid values"
        agreed = Handshake.from_values(values, bool(answer.flags & _LOCKSTEP))
        if agreed is None or len(values) != ACK_VALUES + handshake.states:
            raise HardwareError(invalid)
        if agreed.with_watchdog(handshake.watchdog) != handshake:
            raise HardwareError(
                f"the device at {self.uri} accepted other parameters than requested: "
                f"{agreed} instead of {handshake}"
            )
        nonce = join_uint64(*map(float, values[HELLO_VALUES:ACK_VALUES]))
        if nonce is None:
            raise HardwareError(invalid)
        self.agreed, self.run_id = agreed, answer.run_id
        self.start_state = values[ACK_VALUES:] * handshake.scale
        self._keys = self._pre_shared.for_run(answer.run_id, nonce)
        self._key = self._keys.key_for(_SETPOINT)
        self._writer = FrameWriter(handshake.commands)
        self._seq = self._newest_seq = 0
        self._newest_at = -math.inf
        self._moving = True

    def exchange(self, t: float, command: FloatArray, deadline: float) -> Exchange:
        """Send a set point and wait for the answer; see `HardwareLink.exchange`."""
        agreed = self.agreed
        if agreed is None:
            raise HardwareError(f"the link to {self.uri} is not open")
        if not self._seq and self._is_late() and not self._confirm(agreed):
            self._agree(agreed)
        self._seq = seq = (self._seq + 1) & 0xFFFFFFFF
        sent = self._set_point(t, command, agreed)
        self._send(sent)
        newest: Frame | None = None
        until = (
            min(deadline, self.clock.monotonic() + _REPEAT_PERIOD) if agreed.lockstep else deadline
        )
        for _ in range(_MAX_FRAMES):
            frame = self._next_frame(self._keys, self.run_id, until)
            if frame is None:
                now = self.clock.monotonic()
                if now >= deadline:
                    break
                self._send(sent)
                self.counters["repeated"] += 1
                until = min(deadline, now + _REPEAT_PERIOD)
            elif self._is_new_state(frame, agreed):
                newest = frame
                if frame.seq == seq:
                    break
        return self._exchange_result(newest, agreed)

    def _set_point(self, t: float, command: FloatArray, agreed: Handshake) -> bytes:
        writer = self._writer
        writer.values[:] = command if agreed.scale == 1.0 else command / agreed.scale
        flags = _LOCKSTEP if agreed.lockstep else 0
        now = self.clock.monotonic_ns()
        return writer.pack(_SETPOINT, flags, self.run_id, self._seq, t, now, 0, self._key)

    def _is_new_state(self, frame: Frame, agreed: Handshake) -> bool:
        """Return whether a frame contains a newer state than all earlier frames.

        The state must answer a set point of this run; other frames are counted as dropped.
        """
        if frame.kind is not _STATE or len(frame.values) != agreed.states:
            self.counters["type" if frame.kind is not _STATE else "count"] += 1
            return False
        if not is_newer(frame.seq, self._newest_seq) or is_newer(frame.seq, self._seq):
            self.counters["stale"] += 1
            return False
        self._newest_seq, self._newest_at = frame.seq, self.clock.monotonic()
        return True

    def _exchange_result(self, newest: Frame | None, agreed: Handshake) -> Exchange:
        age = self.clock.monotonic() - self._newest_at
        if newest is None:
            self.counters["missed"] += 1
            return Exchange(None, self._newest_seq, age, math.nan, 0)
        state = np.asarray(newest.values)
        state = state * agreed.scale if agreed.scale != 1.0 else state
        round_trip = self._newest_at - newest.echo_ns * 1e-9
        return Exchange(state, newest.seq, age, round_trip, newest.flags)

    def _next_frame(self, keys: Keys, run_id: int, deadline: float) -> Frame | None:
        """Return the next valid frame of a run, or None. Other frames are dropped and counted."""
        for _ in range(_MAX_FRAMES):
            data = self._receive(deadline)
            if data is None:
                return None
            self.counters["received"] += 1
            try:
                frame = keys.unpack(data)
            except FrameError as error:
                self.counters[error.reason] += 1
                continue
            if frame.run_id == run_id:
                return frame
            self.counters["run"] += 1
        return None

    def stop(self) -> bool:
        """Stop the device. Return whether it confirms the stop within 0.2 s."""
        if not self._moving:
            return False
        self._moving = False
        key = self._keys.key_for(Kind.STOP)
        for _ in range(_MAX_STOPS):
            sent = self.clock.monotonic_ns()
            frame = Frame(Kind.STOP, 0, self.run_id, self._seq, 0.0, sent, 0, ())
            self._send(pack(frame, key))
            until = self.clock.monotonic() + _STOP_PERIOD
            while (answer := self._next_frame(self._keys, self.run_id, until)) is not None:
                if answer.kind is Kind.STOPPED:
                    return True
        return False

    def close(self) -> None:
        """Stop the device if a run is in progress, and close the transport."""
        try:
            self.stop()
        finally:
            self._moving, self.agreed = False, None
            self._disconnect()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
