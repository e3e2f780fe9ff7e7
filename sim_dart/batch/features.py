"""Features: numbers of the state of an instance, scaled, plus its targets."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Feature = NDArray[Any]

_FEATURE = np.dtype(
    [("column", "i4"), ("target", "i4"), ("norm", "i4"), ("unused", "i4"), ("scale", "f8")]
)


def features(
    columns: ArrayLike, scale: float = 1.0, target: int | None = None, norm: int = -1
) -> Feature:
    """Return features for `Rules` of episodes.

    Args:
        columns: Columns of the numbers, see `Batch.columns`; -1 for 0.
        scale: Factor of the numbers.
        target: Index of the target that is added to the first number; the others count up.
        norm: 0 for features of the distance, 1 for features of the effort; -1 for others.
    """
    rows = np.zeros(np.size(columns), _FEATURE)
    rows["column"], rows["scale"], rows["norm"] = columns, scale, norm
    rows["target"] = -1 if target is None else target + np.arange(len(rows))
    return rows
