"""Times that are whole multiples of one another."""

from __future__ import annotations

import math

from addin_sdfusion.robot import InputError

_TOLERANCE = 1e-9

MAX_STEPS = 100_000
"""Steps that a model takes in one call at most: a host that asks for more waits for too long."""


def whole_steps(
    time: float, step: float, what: str, *, key: str | None = None, most: float = math.inf
) -> int:
    """Return the number of steps in a time.

    Args:
        time: In [s].
        step: In [s].
        what: Name of the step, for the message.
        key: Key of the time, for the message.
        most: The largest number of steps.

    Returns:
        A whole number of at least 1.

    Raises:
        InputError: The time is not a whole multiple of the step, or too many of them.
    """
    ratio = time / step
    if ratio > most + 0.5:
        what = f"{time!r} s is {ratio:.6g} times {what}, {step!r} s"
        raise InputError(f"{what}; the maximum is {most}; use shorter steps", key=key)
    steps = round(ratio) if math.isfinite(ratio) else 0
    if steps < 1 or abs(ratio - steps) > _TOLERANCE * steps:
        raise InputError(f"{time!r} s is not a whole multiple of {what}, {step!r} s", key=key)
    return steps


def whole_duration(time: float, step: float) -> float:
    """Return the time, or if it is not a whole multiple of the step, the next one above.

    Args:
        time: In [s].
        step: In [s].
    """
    ratio = time / step
    if not math.isfinite(ratio) or abs(ratio - round(ratio)) <= _TOLERANCE * ratio:
        return time
    return float(f"{math.ceil(ratio) * step:.12g}")
