"""Uniform B-splines of fifth order on a grid.

Positions are within the range of the control points c_k. Velocities are within the range of
(c_k+1 - c_k) / D, where D is the time between two knots.
"""

from __future__ import annotations

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray

GRID = 0.02
"""Time between two rows of a motion, in [s]."""

KNOTS = 0.5
"""Time D between two knots, in [s]."""

PER_SPAN = round(KNOTS / GRID)
ORDER = 5


def basis(order: int) -> FloatArray:
    """Return the derivative of the six basis functions of a span on the grid, shape (k, 6).

    Args:
        order: Order of the derivative; 0 for positions.
    """
    from scipy.interpolate import BSpline  # slow to import

    x = np.arange(PER_SPAN + 1) / PER_SPAN
    splines = BSpline(np.arange(-ORDER, ORDER + 2), np.eye(ORDER + 1), ORDER)
    return np.asarray(splines(x, order) / KNOTS**order)
