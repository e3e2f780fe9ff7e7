"""Checks of numbers and vectors. The arguments `name` identify the value in error messages."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError

from .arrays import FloatArray

MAX_NORM = 8
"""Largest finite norm of forces. Higher powers exceed the precision of floats."""

MAX_PRETENSION = 1e9
"""Largest pretension, in [N]. Larger values lose the force limits by rounding."""


def is_finite(value: object) -> bool:
    """Return whether a value is a finite number."""
    return isinstance(value, Real) and math.isfinite(value)


def float_array(name: str, values: ArrayLike) -> FloatArray:
    """Return a copy of the values as floats, of any shape; InputError if one is not a number."""
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name} must be numbers, not {values!r}") from None


def finite_vector(name: str, values: ArrayLike, size: int) -> FloatArray:
    """Return a vector of `size` finite numbers, shape (size,); InputError for other values."""
    try:
        vector = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name} must be {size} numbers, not {values!r}") from None
    if vector.shape != (size,) or not np.isfinite(vector).all():
        raise InputError(f"{name} must be {size} finite numbers, not {values!r}")
    return vector


def named_vector(
    quantity: str,
    values: ArrayLike,
    names: Sequence[str],
    *,
    above: float | None = None,
    upper: float = np.inf,
    infinite: bool = False,
) -> FloatArray:
    """Return non-negative numbers, one per name, shape (n,), from a number or a vector.

    Args:
        quantity: Name of the quantity for messages.
        values: One number for all names, or one number per name.
        names: n names.
        above: Exclusive lower limit (default: numbers must be at least 0).
        upper: Inclusive upper limit.

    Raises:
        InputError: A value is out of range, or the number of values is wrong.
    """
    n = len(names)
    try:
        vector = np.array(np.broadcast_to(np.asarray(values, dtype=np.float64), (n,)))
    except (TypeError, ValueError):
        raise InputError(f"{quantity} must be a number or {n} numbers, not {values!r}") from None
    for name, value in zip(names, vector, strict=True):
        large_enough = value >= 0 if above is None else value > above
        if not (large_enough and (infinite or np.isfinite(value))):
            allowed = "not negative" if above is None else f"above {above:g}"
            finite = "" if infinite else "finite and "
            raise InputError(f"{quantity} of {name!r} must be {finite}{allowed}: {value}")
        if value > upper:
            raise InputError(f"{quantity} of {name!r} must not be above {upper:g}: {value}")
    return vector


def require_norm(norm: float) -> float:
    """Check and return the norm of forces to minimise.

    Raises:
        InputError: The norm is not an integer from 1 to 8 and not infinity.
    """
    if norm not in (*range(1, MAX_NORM + 1), math.inf):
        raise InputError(f"norm must be an integer from 1 to {MAX_NORM}, or infinity: {norm!r}")
    return float(norm)


def force_bounds(
    names: Sequence[str], f_min: ArrayLike, f_max: ArrayLike, motors: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Check and return the limits of muscles, whose forces are not negative, and of motors.

    Args:
        names: Names of the a actuators: muscles, then motors.
        f_min: Lower limits, a number or shape (a,), in [N] and [N·m]; -inf for a motor without a
            limit.
        f_max: Upper limits, a number or shape (a,), in [N] and [N·m]; may be infinite.

    Raises:
        InputError: A limit is invalid; the message names the actuator.
    """
    n, bounds = len(names), []
    for symbol, values in (("f_min", f_min), ("f_max", f_max)):
        array = float_array(symbol, values)
        if array.shape not in ((), (n,)):
            raise InputError(f"{symbol} must be a number or {n} numbers, not {values!r}")
        bounds.append(np.array(np.broadcast_to(array, (n,))))
    low, high = bounds
    for k, (name, lower, upper) in enumerate(zip(names, low, high, strict=True)):
        is_motor = k >= len(names) - motors
        actuator, symbol = (f"motor {name!r}", "tau") if is_motor else (f"muscle {name!r}", "f")
        if not is_motor and not (np.isfinite(lower) and lower >= 0):
            raise InputError(f"{actuator}: {symbol}_min {lower} must be finite and not negative")
        if not (lower <= upper and lower < np.inf and upper > -np.inf):
            raise InputError(f"{actuator}: {symbol}_min {lower} is above {symbol}_max {upper}")
    return low, high


def smallest_forces(f_min: FloatArray, f_max: FloatArray) -> FloatArray:
    """Return the force of smallest magnitude within the limits of each muscle and motor."""
    smallest: FloatArray = np.clip(0.0, f_min, f_max)
    return smallest


def require_positive(**values: float) -> None:
    """Raise InputError for numbers that are not positive and finite."""
    for name, value in values.items():
        if not (is_finite(value) and value > 0):
            raise InputError(f"{name} must be positive and finite, not {value!r}")


def require_delay(delay: int) -> None:
    """Raise InputError for a delay that is not 0 or 1 ticks."""
    if delay not in (0, 1):
        raise InputError(f"delay must be 0 or 1 ticks, not {delay!r}")


def check_sizes(names: Sequence[str], **vectors: ArrayLike | None) -> None:
    """Check that every vector has one number per name; None is ignored.

    Raises:
        InputError: A vector has another shape; the message names it.
    """
    for symbol, vector in vectors.items():
        if vector is not None and np.shape(vector) != (len(names),):
            raise InputError(
                f"{symbol} has shape {np.shape(vector)}, not ({len(names)},): {', '.join(names)}"
            )
