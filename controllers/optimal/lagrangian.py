"""Contribution of the dynamics to the Hessian of the Lagrangian, by symmetric rank-one updates."""

from __future__ import annotations

import numpy as np

from controllers.arrays import FloatArray

_MIN_ANGLE = 1e-4  # cosine between a step and the error of its secant


class DynamicsHessian:
    """Hessians C_k of lambda_k' Phi_k(z_k), where Phi_k is the end of interval k.

    With the error e = y - C s of the secant for a step s and the change y of the gradient,
    C + e e' / (e' s) satisfies the secant condition C s = y.

    Args:
        count: Number of intervals N.
        variables: Number nz of the variables of each interval.

    Attributes:
        blocks: C, shape (N, nz, nz).
    """

    def __init__(self, count: int, variables: int) -> None:
        self.blocks = np.zeros((count, variables, variables))

    def update(self, step: FloatArray, change: FloatArray) -> None:
        """Satisfy the secant condition of a step and the change of the gradient, shape (N, nz)."""
        error = change - np.einsum("kij,kj->ki", self.blocks, step)
        below = (error * step).sum(axis=1)
        size = np.linalg.norm(error, axis=1) * np.linalg.norm(step, axis=1)
        good = abs(below) > _MIN_ANGLE * size
        e = error[good]
        self.blocks[good] += e[:, :, None] * e[:, None, :] / below[good, None, None]
