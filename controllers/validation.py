"""Checks of numbers and vectors that a caller gives; `what` and `name` are for the messages."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError

from .arrays import FloatArray

MAX_NORM = 8
"""Of forces, but infinity: with more the largest forces alone would count for a float."""

MAX_PRETENSION = 1e9
"""In [N]: beside much larger ones rounding loses the bounds of forces."""


def is_finite(value: object) -> bool:
    """Return whether a value is a number, and neither infinite nor NaN."""
    return isinstance(value, Real) and math.isfinite(value)


def float_array(what: str, values: ArrayLike) -> FloatArray:
    """Return a copy of the values as floats, of any shape; InputError if they are no numbers."""
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} must be numbers, not {values!r}") from None


def finite_vector(what: str, values: ArrayLike, size: int) -> FloatArray:
    """The values as floats, shape (size,); InputError if they are not that many finite numbers."""
    try:
        vector = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} must be {size} numbers, not {values!r}") from None
    if vector.shape != (size,) or not np.isfinite(vector).all():
        raise InputError(f"{what} must be {size} finite numbers, not {values!r}")
    return vector


def named_vector(
    what: str,
    values: ArrayLike,
    names: Sequence[str],
    *,
    above: float | None = None,
    most: float = np.inf,
    infinite: bool = False,
) -> FloatArray:
    """Numbers that are not negative, one for each name, shape (n,), from a number or a vector.

    Args:
        what: What they are.
        values: A number for all, or one each.
        names: n names.
        above: They must be above this; at least 0 when None.
        most: They may be no larger.
        infinite: Whether infinity is allowed.

    Raises:
        InputError: A value is out of range, or there are too many or too few.
    """
    n = len(names)
    try:
        vector = np.array(np.broadcast_to(np.asarray(values, dtype=np.float64), (n,)))
    except (TypeError, ValueError):
        raise InputError(f"{what} must be a number or {n} numbers, not {values!r}") from None
    for name, value in zip(names, vector, strict=True):
        large_enough = value >= 0 if above is None else value > above
        if not (large_enough and (infinite or np.isfinite(value))):
            allowed = "not negative" if above is None else f"above {above:g}"
            finite = "" if infinite else "finite and "
            raise InputError(f"{what} of {name!r} must be {finite}{allowed}: {value}")
        if value > most:
            raise InputError(f"{what} of {name!r} must not be above {most:g}: {value}")
    return vector


def require_norm(norm: float) -> float:
    """Return the norm of forces that is to be least, if it is one.

    Raises:
        InputError: It is none of the whole numbers from 1 to 8, and not infinity.
    """
    if norm not in (*range(1, MAX_NORM + 1), math.inf):
        raise InputError(f"norm must be a whole number from 1 to {MAX_NORM}, or infinity: {norm!r}")
    return float(norm)


def force_bounds(
    names: Sequence[str], f_min: ArrayLike, f_max: ArrayLike, motors: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Bounds of muscles, which only pull, and of motors behind them, which push as well.

    Args:
        names: Of the a actuators.
        f_min: Lower bounds, a number or shape (a,), in [N] and [N·m]; -inf for a motor without one.
        f_max: Upper bounds, likewise; may be infinite.
        motors: How many of them are motors.

    Raises:
        InputError: A bound is wrong; the message names the actuator.
    """
    n, bounds = len(names), []
    for what, values in (("f_min", f_min), ("f_max", f_max)):
        given = float_array(what, values)
        if given.shape not in ((), (n,)):
            raise InputError(f"{what} must be a number or {n} numbers, not {values!r}")
        bounds.append(np.array(np.broadcast_to(given, (n,))))
    low, high = bounds
    for k, (name, least, most) in enumerate(zip(names, low, high, strict=True)):
        is_motor = k >= len(names) - motors
        what = f"motor {name!r}: tau" if is_motor else f"muscle {name!r}: f"
        if not is_motor and not (np.isfinite(least) and least >= 0):
            raise InputError(f"{what}_min {least} must be finite and not negative")
        if not (least <= most and least < np.inf and most > -np.inf):
            raise InputError(f"{what}_min {least} is above {what.split()[-1]}_max {most}")
    return low, high


def resting(f_min: FloatArray, f_max: FloatArray) -> FloatArray:
    """The smallest forces: f_min of muscles, and no torque of motors, where bounds allow it."""
    smallest: FloatArray = np.clip(0.0, f_min, f_max)
    return smallest


def require_positive(**values: float) -> None:
    """Reject numbers that are not positive and finite with an InputError."""
    for name, value in values.items():
        if not (is_finite(value) and value > 0):
            raise InputError(f"{name} must be positive and finite, not {value!r}")


def require_period(period: float) -> None:
    """Reject a sampling period in [s] that is not positive and finite with an InputError."""
    if not (is_finite(period) and period > 0):
        raise InputError(f"period must be a positive time in s, not {period!r}")


def require_delay(delay: int) -> None:
    """Reject a delay that is not 0 or 1 ticks with an InputError."""
    if delay not in (0, 1):
        raise InputError(f"delay must be 0 or 1 ticks, not {delay!r}")


def check_sizes(names: Sequence[str], **vectors: ArrayLike | None) -> None:
    """Reject vectors that do not have one number for every name; None is left out.

    Raises:
        InputError: A vector has another shape; the message names it.
    """
    for what, vector in vectors.items():
        if vector is not None and np.shape(vector) != (len(names),):
            raise InputError(
                f"{what} has shape {np.shape(vector)}, not ({len(names)},): {', '.join(names)}"
            )


def positive_or_none(what: str, value: float | None, unit: str) -> float | None:
    """Return a positive, finite number in `unit`, or None; InputError for others."""
    if value is not None and not (is_finite(value) and value > 0):
        raise InputError(f"{what} must be positive, in {unit}, or None: {value!r}")
    return value
