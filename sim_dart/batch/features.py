"""Features: numbers of the state of an instance, scaled, plus its targets."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Feature = NDArray[Any]

NORMS = 2
"""Number of norms, BATCH_NORMS."""

_FEATURE = np.dtype(
    [("column", "i4"), ("target", "i4"), ("norm", "i4"), ("unused", "i4"), ("scale", "f8")]
)


def features(
    columns: ArrayLike, scale: float = 1.0, target: int | None = None, norm: int = -1
) -> Feature:
    """Return features for `Batch.features`.

    Args:
        columns: Columns of the numbers, see `Batch.columns`; -1 for 0.
        scale: Factor of the numbers.
        target: Index of the target that is added to the first number; the others count up.
        norm: Index of the norm that includes the features, 0 or 1; -1 for none.
    """
    rows = np.zeros(np.size(columns), _FEATURE)
    rows["column"], rows["scale"], rows["norm"] = columns, scale, norm
    rows["target"] = -1 if target is None else target + np.arange(len(rows))
    return rows
