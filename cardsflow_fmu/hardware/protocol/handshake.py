"""Handshake before a run: parameters of the run, and reasons to reject it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import IntEnum

HELLO_VALUES = 7
ACK_VALUES = HELLO_VALUES + 2
"""Number of values of a HELLO_ACK before the state: the values of a HELLO, and the nonce."""

_TWO_TO_32 = 0x1_0000_0000


class ErrorCode(IntEnum):
    """Reason to reject a run: the first value of an ERROR frame."""

    BUSY = 1
    PORTS = 2
    SCALE = 3
    STEP = 4
    WATCHDOG = 5
    MODE = 6
    FAULT = 7


REJECTION_REASONS = {
    ErrorCode.BUSY: "another run uses it; end that run first",
    ErrorCode.PORTS: "its signals differ in names, units, order, or kind of command; "
    "use the same robot and the same [hardware.motors] on both sides",
    ErrorCode.SCALE: "it uses a different scale; set the same scale on both sides",
    ErrorCode.STEP: "it does not support this time step; the time step must be positive, and in "
    "lockstep 1 to 1000 steps of the device",
    ErrorCode.WATCHDOG: "its watchdog is shorter than two steps; reduce the time step, or set a "
    "longer watchdog on the device",
    ErrorCode.MODE: "it does not support this mode; use the other mode (realtime or lockstep)",
    ErrorCode.FAULT: "its robot has failed; check the hardware",
}


@dataclass(frozen=True, slots=True)
class Handshake:
    """Parameters of a run.

    Attributes:
        signature: Hash of the signals, 64 bits; see `signature.port_signature`.
        step: Time between set points, in [s].
        scale: Scale of the values in frames. A value in a frame is the SI value divided by it.
        watchdog: Time without a command after which the device enters its safe state, in [s].
        commands: Number of values of a set point.
        lockstep: Whether the device advances by one step for each set point. Otherwise the robot
            moves in real time.
    """

    signature: int
    step: float
    scale: float
    watchdog: float
    commands: int
    states: int
    lockstep: bool

    def values(self) -> list[float]:
        """Return the values of a HELLO. They do not include the mode, which is a flag."""
        return [
            *split_uint64(self.signature),
            self.step,
            self.scale,
            self.watchdog,
            self.commands,
            self.states,
        ]

    @classmethod
    def from_values(cls, values: Iterable[float], lockstep: bool) -> Handshake | None:
        """Return the parameters in the values of a HELLO or a HELLO_ACK, or None if invalid.

        Step, scale and watchdog are not checked: a device answers with an ERROR.

        Args:
            values: At least 7 finite numbers.
            lockstep: Whether the flag LOCKSTEP of the frame is set.
        """
        numbers = [float(value) for value in values]
        if len(numbers) < HELLO_VALUES:
            return None
        high, low, step, scale, watchdog, commands, states = numbers[:HELLO_VALUES]
        signature = join_uint64(high, low)
        counts = (commands, states)
        if signature is None or not all(0 <= n < 2**16 and n == int(n) for n in counts):
            return None
        return cls(signature, step, scale, watchdog, int(commands), int(states), lockstep)

    def with_watchdog(self, watchdog: float) -> Handshake:
        """Return a copy with another watchdog timeout, in [s]."""
        return replace(self, watchdog=watchdog)


def split_uint64(number: int) -> tuple[float, float]:
    """Return the upper and the lower 32 bits of a 64-bit number, as two floats."""
    return float(number // _TWO_TO_32), float(number % _TWO_TO_32)


def join_uint64(high: float, low: float) -> int | None:
    """Return the 64-bit number with the given upper and lower 32 bits, or None if invalid."""
    if not all(math.isfinite(x) and 0 <= x < _TWO_TO_32 and x == int(x) for x in (high, low)):
        return None
    return int(high) * _TWO_TO_32 + int(low)
