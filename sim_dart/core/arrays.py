"""Types of numpy arrays, and checks of vectors that are passed by a caller."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot import InputError

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int32]


def vector(label: str, values: ArrayLike, size: int) -> FloatArray:
    """Return the values as a contiguous float array of shape (size,).

    Raises:
        InputError: The values have another shape or are not numbers.
    """
    try:
        array = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{label} must be {size} numbers, not {values!r}") from None
    if array.shape != (size,):
        raise InputError(f"{label} must have shape ({size},), not {array.shape}")
    return array


def finite(label: str, values: ArrayLike, size: int) -> FloatArray:
    """Return the values as a contiguous float array of shape (size,), and require finite values.

    DART does not report values that are not finite. It returns the terms of an older state.

    Raises:
        InputError: The values have another shape, are not numbers, or are not finite.
    """
    array = vector(label, values, size)
    if not np.isfinite(array).all():
        raise InputError(f"{label} must be finite, not {array}")
    return array
