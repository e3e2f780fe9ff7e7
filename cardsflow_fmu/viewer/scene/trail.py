"""Beads along a way: the spheres of a trail."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cardsflow_fmu.utils.arrays import FloatArray

_MOST = 4000


def beads_along(way: FloatArray, apart: float) -> tuple[FloatArray, NDArray[np.int64]]:
    """Points at even distances along a way.

    Args:
        way: Its corners, shape (K, 3), in [m].
        apart: Their distance along it, in [m]; more, where there would be too many.

    Returns:
        The points, shape (b, 3), and how many of them lie before each corner, shape (K,).
    """
    way = np.nan_to_num(way)
    steps = np.linalg.norm(np.diff(way, axis=0), axis=1)
    walked = np.concatenate([[0.0], np.cumsum(steps)])
    apart = max(apart, walked[-1] / _MOST)
    passed = np.floor(walked / apart).astype(np.int64) + 1
    places = apart * np.arange(passed[-1])
    beads = np.stack([np.interp(places, walked, way[:, axis]) for axis in range(3)], axis=1)
    return beads, passed
