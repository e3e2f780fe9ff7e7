"""Capabilities of a device, and the check of a requested run against them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from cardsflow_fmu.hardware.protocol.handshake import ErrorCode, Handshake
from cardsflow_fmu.utils.arrays import FloatArray

MAX_STEPS = 1000
"""Maximum number of device steps per set point in lockstep, which bounds the computing time."""

_ROUNDING = 1e-6
"""Relative tolerance of the check for whole numbers of steps."""


@dataclass(frozen=True, slots=True)
class Capabilities:
    """Capabilities of a device; the values are those of a `Handshake`."""

    signature: int
    step: float
    scale: float
    watchdog: float
    commands: int
    states: int

    def __post_init__(self) -> None:
        for name in ("step", "scale", "watchdog"):
            if not 0 < getattr(self, name) < math.inf:
                problem = f"must be a positive number, not {getattr(self, name)}"
                raise InputError(f"a device's {name} {problem}")

    def rejection(self, request: Handshake) -> ErrorCode | None:
        """Return the reason to reject the requested run, or None if the device supports it."""
        if (request.commands, request.states) != (self.commands, self.states):
            return ErrorCode.PORTS
        if request.scale != self.scale:
            return ErrorCode.SCALE
        if request.signature != self.signature:
            return ErrorCode.PORTS
        if not request.step > 0:
            return ErrorCode.STEP
        if request.watchdog < 0:
            return ErrorCode.WATCHDOG
        if request.lockstep:
            return None if self._is_multiple_of_step(request.step) else ErrorCode.STEP
        is_too_short = self.run_parameters(request).watchdog < 2 * request.step
        return ErrorCode.WATCHDOG if is_too_short else None

    def run_parameters(self, request: Handshake) -> Handshake:
        """Return the parameters of the run.

        They equal the request, except that the watchdog is the shorter one of device and request.
        """
        return request.with_watchdog(min(self.watchdog, request.watchdog or math.inf))

    def _is_multiple_of_step(self, time: float) -> bool:
        """Return whether a time is a whole number of device steps, from 1 to `MAX_STEPS`."""
        steps = min(time / self.step, MAX_STEPS + 1.0)
        is_whole = abs(steps - round(steps)) <= _ROUNDING * steps
        return is_whole and 1 <= round(steps) <= MAX_STEPS


def bounds(value: ArrayLike, count: int, name: str) -> FloatArray:
    """Return the bounds of all commands, shape (count,).

    Args:
        value: One bound for all commands, or an array of shape (count,).
        name: Name of the bound, used in messages.

    Raises:
        InputError: The shape is wrong, or a bound is NaN.
    """
    values = np.asarray(value, float)
    if np.isnan(values).any() or values.shape not in ((), (count,)):
        raise InputError(f"a device's {name} must be one number or {count} numbers, without NaN")
    return np.broadcast_to(values, (count,)).copy()
