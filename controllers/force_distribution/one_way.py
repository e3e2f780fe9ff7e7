"""Motors among muscles that only pull: each as two pulls, one each way.

    tau = p - n,   0 <= p <= tau_max,   0 <= n <= -tau_min

The torques that are possible are the same, and so are the least sum and the least sum of squares:
with both above zero, less of both would do. So what is known of muscles holds for robots with
motors.
"""

from __future__ import annotations

import numpy as np

from controllers.arrays import FloatArray


def one_way(
    L: FloatArray, f_min: FloatArray, f_max: FloatArray, motors: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """L and bounds of forces that only pull: muscles, motors one way, motors the other way.

    Args:
        L: Rows of muscles and, behind them, of motors, shape (..., a, n).
        f_min: Lower bounds, shape (a,); of motors any.
        f_max: Upper bounds, shape (a,).
        motors: How many of the last rows are motors.

    Returns:
        L, shape (..., a + motors, n), and bounds, shape (a + motors,), which are not negative.
    """
    if not motors:
        return L, f_min, f_max
    low, high = f_min[-motors:], f_max[-motors:]
    nothing = np.zeros(motors)
    least = [f_min[:-motors], np.maximum(low, nothing), np.maximum(-high, nothing)]
    most = [f_max[:-motors], np.maximum(high, nothing), np.maximum(-low, nothing)]
    rows = np.concatenate([L, -L[..., -motors:, :]], axis=-2)
    return rows, np.concatenate(least), np.concatenate(most)


def both_ways(forces: FloatArray, motors: int) -> FloatArray:
    """Forces of `one_way`, shape (..., a + motors), as those of muscles and motors, (..., a)."""
    if not motors:
        return forces
    folded = forces[..., :-motors].copy()
    folded[..., -motors:] -= forces[..., -motors:]
    return folded
