"""Downsampling of lines for drawing: the minimum and maximum of each group of points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cardsflow_fmu.utils.arrays import FloatArray

BINS = 2000
"""More than a figure has pixels beside each other."""


def downsample(x: FloatArray, y: FloatArray, bins: int = BINS) -> tuple[FloatArray, FloatArray]:
    """The points of a line that reach farthest down and up, and its ends; no point is made up.

    Args:
        x: Rising, shape (points,).
        y: Shape (points,). Where a value is nan, the line stays interrupted.
        bins: Number of groups of neighbours; of each, two points are kept.

    Returns:
        The points kept, all of them where they are few.
    """
    size = -(-len(x) // bins)
    if size <= 2:
        return x, y
    whole = len(y) // size * size
    groups = y[:whole].reshape(-1, size)
    firsts = np.arange(0, whole, size)
    kept = [firsts + groups.argmin(axis=1), firsts + groups.argmax(axis=1)]
    if whole < len(y):
        kept.append(whole + np.array([y[whole:].argmin(), y[whole:].argmax()]))
    rows = np.unique(np.concatenate([*kept, [0, len(x) - 1]]))
    return x[rows], y[rows]


def every_few(count: int, points: int = 2 * BINS) -> NDArray[np.int64]:
    """Rows at even distances, the last one always among them.

    Args:
        count: Number of rows there are.
        points: Most rows to take.
    """
    step = max(-(-count // points), 1)
    return np.unique(np.append(np.arange(0, count, step), max(count - 1, 0)))[: max(count, 0)]
