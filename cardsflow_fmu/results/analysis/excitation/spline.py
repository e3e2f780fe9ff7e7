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
    x = np.arange(PER_SPAN + 1) / PER_SPAN
    B = _uniform_splines(ORDER - order, x)
    for _ in range(order):  # differences of the control points
        B = np.pad(B, ((0, 0), (1, 0))) - np.pad(B, ((0, 0), (0, 1)))
    return B / KNOTS**order


def _uniform_splines(degree: int, x: FloatArray) -> FloatArray:
    """Return the nonzero uniform B-splines of a degree in a span, shape (k, degree + 1).

    Args:
        degree: Degree of the splines.
        x: Positions in the span, from 0 to 1, shape (k,).
    """
    B = np.ones((len(x), 1))
    for d in range(1, degree + 1):
        j = np.arange(d)
        right, left = (x[:, None] + d - 1 - j) / d, (j + 1 - x[:, None]) / d
        B = np.pad(B * right, ((0, 0), (1, 0))) + np.pad(B * left, ((0, 0), (0, 1)))
    return B
