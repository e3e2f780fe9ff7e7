"""Uniform B-splines of fifth order on a grid.

Positions stay among the control points c_k, velocities among (c_k+1 - c_k) / D, with D the time
between two knots.
"""

from __future__ import annotations

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray

GRID = 0.02
"""Between two rows of a motion's table, in [s]."""

KNOTS = 0.5
"""D, in [s]."""

PER_SPAN = round(KNOTS / GRID)
ORDER = 5


def basis(order: int) -> FloatArray:
    """A derivative of the spline within a span, on the grid, by control points, shape (k, 6)."""
    x = np.arange(PER_SPAN + 1) / PER_SPAN
    B = _uniform(ORDER - order, x)
    for _ in range(order):  # differences of the control points
        B = np.pad(B, ((0, 0), (1, 0))) - np.pad(B, ((0, 0), (0, 1)))
    return B / KNOTS**order


def _uniform(degree: int, x: FloatArray) -> FloatArray:
    """Uniform B-splines of a degree that are not zero within a span, shape (k, degree + 1)."""
    B = np.ones((len(x), 1))
    for d in range(1, degree + 1):
        j = np.arange(d)
        right, left = (x[:, None] + d - 1 - j) / d, (j + 1 - x[:, None]) / d
        B = np.pad(B * right, ((0, 0), (1, 0))) + np.pad(B * left, ((0, 0), (0, 1)))
    return B
