"""Checks that a time is an integer multiple of a step."""

from __future__ import annotations

import math

from addin_sdfusion.robot import InputError

_TOLERANCE = 1e-9

MAX_STEPS = 100_000
"""Maximum number of steps of a model in one call; more steps would block the host for too long."""


class StepLengthError(InputError):
    """A step whose length is impossible. The model has not changed: another length is possible."""


def whole_steps(
    time: float,
    step: float,
    label: str,
    *,
    key: str | None = None,
    most: float = math.inf,
    parameter: str | None = None,
) -> int:
    """Return the number of steps in a time.

    Args:
        time: In [s].
        step: In [s].
        label: Name of the step, for the message.
        key: Key of the time, for the message.
        most: Maximum number of steps.
        parameter: Parameter that sets the step, for the message.

    Returns:
        Number of steps, at least 1.

    Raises:
        StepLengthError: The time is not an integer multiple of the step, or has too many steps.
    """
    ratio = time / step
    if ratio > most + 0.5:
        problem = f"{time!r} s is {ratio:.6g} times {label}, {step!r} s"
        raise StepLengthError(f"{problem}; the maximum is {most}; use shorter steps", key=key)
    steps = round(ratio) if math.isfinite(ratio) else 0
    if steps < 1 or abs(ratio - steps) > _TOLERANCE * steps:
        problem = f"{time!r} s is not a whole multiple of {label}, {step!r} s"
        if parameter is not None:
            remedy = f"set the parameter {parameter} before the initialization"
            problem += f"; use a multiple, or {remedy}"
        raise StepLengthError(problem, key=key)
    return steps


def whole_duration(time: float, step: float) -> float:
    """Round a time up to an integer multiple of a step, both in [s]."""
    ratio = time / step
    if not math.isfinite(ratio) or abs(ratio - round(ratio)) <= _TOLERANCE * ratio:
        return time
    return float(f"{math.ceil(ratio) * step:.12g}")
