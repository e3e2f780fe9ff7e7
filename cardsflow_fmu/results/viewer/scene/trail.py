"""Points of a trail."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cardsflow_fmu.utils.arrays import FloatArray

_MAX_POINTS = 4000


def trail_points(path: FloatArray, distance: float) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return points at equal distances along a path.

    Args:
        path: Corners of the path, shape (K, 3), in [m].
        distance: Distance of the points along the path, in [m]. It is increased if the number of
            points would exceed 4000.

    Returns:
        The points, shape (b, 3), and the number of points before each corner, shape (K,).
    """
    path = np.nan_to_num(path)
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    walked = np.concatenate([[0.0], np.cumsum(steps)])
    distance = max(distance, walked[-1] / _MAX_POINTS)
    passed = np.floor(walked / distance).astype(np.int64) + 1
    at = distance * np.arange(passed[-1])
    points = np.stack([np.interp(at, walked, path[:, axis]) for axis in range(3)], axis=1)
    return points, passed
