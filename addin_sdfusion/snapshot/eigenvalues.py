"""Eigenvalues of symmetric 3x3 matrices, by Jacobi's rotations."""

from __future__ import annotations

import math

from ..robot.model.pose import Vector3
from ..robot.model.rotations import Matrix3

_SWEEPS = 30
_PAIRS = ((0, 1), (0, 2), (1, 2))


def eigenvalues(A: Matrix3) -> Vector3:
    """Return the eigenvalues in ascending order.

    The errors are in the order of the rounding error of the largest eigenvalue.

    Args:
        A: Symmetric and finite; the lower triangle is not used.
    """
    a = [[A[min(i, j)][max(i, j)] for j in range(3)] for i in range(3)]
    for _ in range(_SWEEPS):
        if all(a[i][j] == 0.0 for i, j in _PAIRS):
            break
        for p, q in _PAIRS:
            _annihilate(a, p, q)
    x, y, z = sorted(a[i][i] for i in range(3))
    return x, y, z


def _annihilate(a: list[list[float]], p: int, q: int) -> None:
    """Rotate about the third axis so that the entry p, q becomes zero."""
    b = a[p][q]
    if abs(b) <= 1e-17 * (abs(a[p][p]) + abs(a[q][q])):
        a[p][q] = a[q][p] = 0.0
        return
    theta = (a[q][q] - a[p][p]) / (2.0 * b)
    t = math.copysign(1.0, theta) / (abs(theta) + math.hypot(theta, 1.0))
    c = 1.0 / math.hypot(t, 1.0)
    s = t * c
    r = 3 - p - q
    a[p][p] -= t * b
    a[q][q] += t * b
    a[p][q] = a[q][p] = 0.0
    u, v = a[r][p], a[r][q]
    a[r][p] = a[p][r] = c * u - s * v
    a[r][q] = a[q][r] = s * u + c * v
