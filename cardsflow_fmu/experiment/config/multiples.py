"""Times in settings that must be whole multiples of a step."""

from __future__ import annotations

import math
from pathlib import Path

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.multiples import whole_steps

MAX_STEPS = 10_000_000


def require_multiple(
    time: float,
    step: float,
    step_key: str,
    *,
    file: Path,
    key: str,
    blame: str | None = None,
    most: float = math.inf,
) -> None:
    """Check that a time is a multiple of a step, with a limited number of steps.

    Args:
        time: Time, in [s].
        step: Step, in [s].
        file: File that specifies the time.
        key: Full key of the time.
        blame: Full key for the message (default: key).
        most: Maximum number of steps.

    Raises:
        InputError: The time is not a multiple, or there are too many steps.
    """
    try:
        steps = whole_steps(time, step, step_key, most=most)
    except InputError as error:
        raise InputError(error.problem, file=file, key=blame or key) from None
    if steps > MAX_STEPS:
        problem = f"{steps:g} steps exceed the maximum of a run (10 million)"
        raise InputError(problem, file=file, key=key)
