"""Downsampling of lines for drawing: the minimum and maximum of each group of points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cardsflow_fmu.utils.arrays import FloatArray

BINS = 2000
"""Number of bins; larger than the width of a figure in pixels."""


def downsample(x: FloatArray, y: FloatArray, bins: int = BINS) -> tuple[FloatArray, FloatArray]:
    """Select the minimum and maximum of each group of points, and the ends of a line.

    Args:
        x: Increasing values, shape (points,).
        y: Values, shape (points,). The line remains interrupted at nan.
        bins: Number of groups; two points per group are selected.
    """
    size = -(-len(x) // bins)
    if size <= 2:
        return x, y
    grouped = len(y) // size * size
    groups = y[:grouped].reshape(-1, size)
    firsts = np.arange(0, grouped, size)
    selected = [firsts + groups.argmin(axis=1), firsts + groups.argmax(axis=1)]
    if grouped < len(y):
        selected.append(grouped + np.array([y[grouped:].argmin(), y[grouped:].argmax()]))
    rows = np.unique(np.concatenate([*selected, [0, len(x) - 1]]))
    return x[rows], y[rows]


def evenly_spaced(count: int, points: int = 2 * BINS) -> NDArray[np.int64]:
    """Select evenly spaced rows, including the last one."""
    step = max(-(-count // points), 1)
    return np.unique(np.append(np.arange(0, count, step), max(count - 1, 0)))[: max(count, 0)]
