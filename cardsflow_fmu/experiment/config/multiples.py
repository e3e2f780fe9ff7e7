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
    what: str,
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
        what: Full key of the step.
        file: File that specifies the time.
        key: Full key of the time.
        blame: Full key for the message (default: key).
        most: Maximum number of steps.

    Raises:
        InputError: The time is not a multiple, or there are too many steps.
    """
    try:
        steps = whole_steps(time, step, what, most=most)
    except InputError as error:
        raise InputError(error.problem, file=file, key=blame or key) from None
    if steps > MAX_STEPS:
        what = f"{steps:g} steps exceed the maximum of a run (10 million)"
        raise InputError(what, file=file, key=key)
