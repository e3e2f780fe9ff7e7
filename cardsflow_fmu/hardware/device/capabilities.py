"""The capabilities of a device, and its answer to a handshake."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from cardsflow_fmu.hardware.protocol.handshake import ErrorCode, Handshake
from cardsflow_fmu.utils.arrays import FloatArray

MAX_STEPS = 1000
"""A set point in lockstep takes no more steps, so that a link cannot keep a device busy."""

_ROUNDING = 1e-6


@dataclass(frozen=True, slots=True)
class Capabilities:
    """The capabilities of a device.

    Attributes:
        signature: Hash of its signals.
        step: Its own step, in [s].
        scale: A value in a frame is the SI value divided by this.
        watchdog: Longest silence while running, in [s].
        commands: Number of values of a set point.
        states: Number of values of a state.

    Raises:
        InputError: A value is out of range.
    """

    signature: int
    step: float
    scale: float
    watchdog: float
    commands: int
    states: int

    def __post_init__(self) -> None:
        for name in ("step", "scale", "watchdog"):
            if not 0 < getattr(self, name) < math.inf:
                what = f"must be a positive number, not {getattr(self, name)}"
                raise InputError(f"a device's {name} {what}")

    def refusal(self, request: Handshake) -> ErrorCode | None:
        """Return the reason to reject a request; None if it can be met."""
        if (request.commands, request.states) != (self.commands, self.states):
            return ErrorCode.PORTS
        if request.scale != self.scale:
            return ErrorCode.SCALE
        if request.signature != self.signature:
            return ErrorCode.PORTS
        if request.lockstep:
            return None if self._are_whole_steps(request.step) else ErrorCode.STEP
        short = self.agreed(request).watchdog < 2 * request.step
        return ErrorCode.WATCHDOG if short else None

    def agreed(self, request: Handshake) -> Handshake:
        """The parameters of the run: those of the request, with the shorter watchdog of both."""
        return request.with_watchdog(min(self.watchdog, request.watchdog or math.inf))

    def _are_whole_steps(self, time: float) -> bool:
        steps = min(time / self.step, MAX_STEPS + 1.0)
        whole = abs(steps - round(steps)) <= _ROUNDING * steps
        return whole and 1 <= round(steps) <= MAX_STEPS


def bounds(value: ArrayLike, count: int, name: str) -> FloatArray:
    """One bound for each command.

    Args:
        value: A number, or shape (count,).
        count: Number of commands.
        name: For messages.

    Raises:
        InputError: It is neither, or a number is NaN.
    """
    values = np.asarray(value, float)
    if np.isnan(values).any() or values.shape not in ((), (count,)):
        raise InputError(f"a device's {name} must be one number or {count}, none of them NaN")
    return np.broadcast_to(values, (count,)).copy()
