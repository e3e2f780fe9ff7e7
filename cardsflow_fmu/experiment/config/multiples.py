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
    """Refuse a time that is no whole multiple of a step, and more steps than memory has rows.

    Args:
        time: In [s].
        step: In [s].
        what: The full key of the step.
        file: Where the time is given.
        key: The full key of the time.
        blame: The full key that the message names; that of the time when None.
        most: The largest number of steps.

    Raises:
        InputError: It is.
    """
    try:
        steps = whole_steps(time, step, what, most=most)
    except InputError as error:
        raise InputError(error.what, file=file, key=blame or key) from None
    if steps > MAX_STEPS:
        what = f"{steps:g} steps are more than a run can hold (10 million)"
        raise InputError(what, file=file, key=key)
