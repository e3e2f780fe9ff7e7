"""Checks of the arguments of a batch."""

from __future__ import annotations

from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from sim_dart.core.arrays import BoolArray, FloatArray, IntArray


def integer(label: str, value: object, smallest: int) -> int:
    """Return a whole number that is not below `smallest`.

    Raises:
        InputError: The value is something else.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or value < smallest:
        raise InputError(f"{label} must be a whole number from {smallest}, not {value!r}")
    return int(value)


def rows(label: str, values: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Return finite values of all instances; read-only if they are those of one row.

    Args:
        label: Name of the values, for messages.
        values: One row per instance, or one row for all.
        shape: Shape of the array, (n, k).

    Raises:
        InputError: The values have another shape, are not numbers, or are not finite.
    """
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{label} must be numbers of shape {shape}") from None
    if array.shape not in (shape, shape[1:]):
        raise InputError(f"{label} must have shape {shape} or {shape[1:]}, not {array.shape}")
    is_finite = np.isfinite(array)
    if not is_finite.all():
        i, k = np.argwhere(~np.broadcast_to(is_finite, shape))[0].tolist()
        value = array[..., k].flat[i]
        raise InputError(f"{label} must be finite, not {value} (instance {i}, column {k})")
    return array if array.shape == shape else np.broadcast_to(array, shape)


def chosen_instances(chosen: ArrayLike | None, n: int) -> BoolArray:
    """Return the flags of chosen instances, shape (n,); None for all.

    Raises:
        InputError: The values are not n flags.
    """
    mask = np.ones(n, dtype=np.bool_) if chosen is None else np.asarray(chosen)
    if mask.shape != (n,) or mask.dtype != np.bool_:
        raise InputError(
            f"chosen must be {n} flags, not an array of {mask.dtype} with shape {mask.shape}"
        )
    return np.ascontiguousarray(mask)


def indices(label: str, values: ArrayLike, n: int, size: int) -> IntArray:
    """Return n indices below `size`.

    Raises:
        InputError: The values are something else.
    """
    array = np.asarray(values)
    if array.shape != (n,) or array.dtype.kind not in "iu":
        raise InputError(
            f"{label} must be {n} whole numbers, not {array.dtype} with shape {array.shape}"
        )
    if ((array < 0) | (array >= size)).any():
        raise InputError(
            f"{label} must be from 0 to {size - 1}, not {array.min()} to {array.max()}"
        )
    return array.astype(np.int32)
