"""Conversion of motor torques to pairs of non-negative forces, and back.

    tau = p - n,   0 <= p <= tau_max,   0 <= n <= -tau_min

With this conversion, methods for non-negative muscle forces also support motors. The set of
possible torques does not change. In a solution with the minimum sum or the minimum sum of squares,
p or n is zero, so that these minima do not change either.
"""

from __future__ import annotations

import numpy as np

from controllers.arrays import FloatArray


def split_motors(
    L: FloatArray, f_min: FloatArray, f_max: FloatArray, motors: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return L and non-negative force limits of muscles, positive and negative motor torques.

    Args:
        L: Rows of muscles, then of motors, shape (..., a, n).
        f_min: Lower limits, shape (..., a); may be negative for motors.
        f_max: Upper limits, shape (..., a).
        motors: Number of motors, the last rows of L.

    Returns:
        L, shape (..., a + motors, n), f_min and f_max, shape (..., a + motors) each.
    """
    if not motors:
        return L, f_min, f_max
    low, high = f_min[..., -motors:], f_max[..., -motors:]
    lower = [f_min[..., :-motors], np.maximum(low, 0.0), np.maximum(-high, 0.0)]
    upper = [f_max[..., :-motors], np.maximum(high, 0.0), np.maximum(-low, 0.0)]
    rows = np.concatenate([L, -L[..., -motors:, :]], axis=-2)
    return rows, np.concatenate(lower, axis=-1), np.concatenate(upper, axis=-1)


def merge_motors(forces: FloatArray, motors: int) -> FloatArray:
    """Convert forces of `split_motors`, shape (..., a + motors), to f, shape (..., a)."""
    if not motors:
        return forces
    merged = forces[..., :-motors].copy()
    merged[..., -motors:] -= forces[..., -motors:]
    return merged
