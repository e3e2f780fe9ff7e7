"""The handshake before a run: what both sides agree on, and the reasons of a refusal."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import IntEnum

HELLO_VALUES = 7
ACK_VALUES = HELLO_VALUES + 2
"""The 7 values as agreed and the device's nonce; the device's state follows."""

_HALF = 0x1_0000_0000


class ErrorCode(IntEnum):
    """The reason of a refusal: the first value of an ERROR."""

    BUSY = 1
    PORTS = 2
    SCALE = 3
    STEP = 4
    WATCHDOG = 5
    MODE = 6
    FAULT = 7


REFUSALS = {
    ErrorCode.BUSY: "it is in use by another; end that run first",
    ErrorCode.PORTS: "its signals differ: names, units, their order, or the kind of command; "
    "give both sides the same robot and the same [hardware.motors]",
    ErrorCode.SCALE: "it uses another scale; give both sides the same",
    ErrorCode.STEP: "it cannot take this step; in lock step it must be its own, or up to "
    "1000 whole ones",
    ErrorCode.WATCHDOG: "its watchdog is shorter than two steps; take shorter steps, or give the "
    "device a longer watchdog",
    ErrorCode.MODE: "it does not support this mode; choose the other of realtime and lockstep",
    ErrorCode.FAULT: "its robot has failed; look at the hardware",
}


@dataclass(frozen=True, slots=True)
class Handshake:
    """The parameters of a run.

    Attributes:
        signature: Hash of the signals, 64 bits; see `signature.port_signature`.
        step: Time from one set point to the next, in [s].
        scale: A value in a frame is the SI value divided by this.
        watchdog: Without a command for so long the device goes to its safe state, in [s].
        commands: Number of values of a set point.
        states: Number of values of a state.
        lockstep: Whether the device takes a step for each set point, instead of going by its clock.
    """

    signature: int
    step: float
    scale: float
    watchdog: float
    commands: int
    states: int
    lockstep: bool

    def values(self) -> list[float]:
        """Return the values of a HELLO; the mode is a flag of the frame."""
        return [
            *halves(self.signature),
            self.step,
            self.scale,
            self.watchdog,
            self.commands,
            self.states,
        ]

    @classmethod
    def of_values(cls, values: Iterable[float], lockstep: bool) -> Handshake | None:
        """The handshake in a HELLO, or at the beginning of a HELLO_ACK; None if it is invalid.

        Args:
            values: At least 7 finite numbers.
            lockstep: The frame's flag.
        """
        numbers = [float(value) for value in values]
        if len(numbers) < HELLO_VALUES:
            return None
        high, low, step, scale, watchdog, commands, states = numbers[:HELLO_VALUES]
        signature = whole(high, low)
        counts = (commands, states)
        if signature is None or not all(0 <= n < 2**16 and n == int(n) for n in counts):
            return None
        if step <= 0 or scale <= 0 or watchdog < 0:
            return None
        return cls(signature, step, scale, watchdog, int(commands), int(states), lockstep)

    def with_watchdog(self, watchdog: float) -> Handshake:
        """Return the same with another watchdog, in [s]."""
        return replace(self, watchdog=watchdog)


def halves(number: int) -> tuple[float, float]:
    """Return a 64-bit number as two floats that hold 32 bits each, the higher first."""
    return float(number // _HALF), float(number % _HALF)


def whole(high: float, low: float) -> int | None:
    """Return the number of two halves; None if they are none."""
    if not all(math.isfinite(x) and 0 <= x < _HALF and x == int(x) for x in (high, low)):
        return None
    return int(high) * _HALF + int(low)
