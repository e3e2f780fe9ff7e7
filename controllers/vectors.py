"""Vectors that a caller gives, checked."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot import InputError

FloatArray = NDArray[np.float64]


def finite_vector(what: str, values: ArrayLike, size: int) -> FloatArray:
    """The values as floats, shape (size,).

    Args:
        what: What they are, for the message.
        values: The values.
        size: How many there must be.

    Raises:
        InputError: There are too many or too few, or one is not a finite number.
    """
    try:
        vector = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} must be {size} numbers, not {values!r}") from None
    if vector.shape != (size,) or not np.isfinite(vector).all():
        raise InputError(f"{what} must be {size} finite numbers, not {values!r}")
    return vector
