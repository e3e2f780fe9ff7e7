"""Hessians of a problem in stages: blocks, and couplings of adjacent nodes and intervals."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_matrix

from controllers.arrays import FloatArray, IntArray

from .costs import CostTerms
from .problem import OptimalProblem
from .sparse_pattern import SparsePattern


class StageHessian:
    """Hessian with a block for the variables z_k = (x_k, u_k, g) of each node.

    Args:
        problem: The problem.
        x, u, g: Indices of the states, controls and globals, shapes (N + 1, nx), (N, nu), (ng,).
        scale: Scales of z, shape (nz,).
    """

    def __init__(
        self, problem: OptimalProblem, x: IntArray, u: IntArray, g: IntArray, scale: FloatArray
    ) -> None:
        self._problem, self._scale = problem, scale
        self._N, self._nx, self._width = len(u), x.shape[1], x.shape[1] + u.shape[1]
        z, stages, size = np.concatenate([x[:-1], u], axis=1), x[-1, -1] + 1, x[-1, -1] + 1 + len(g)
        every = np.arange(stages)
        pairs = [
            (z[:, :, None], z[:, None, :]),
            (x[-1][:, None], x[-1][None, :]),
            (every[:, None], g[None, :]),
            (g[None, :], every[:, None]),
            (g[:, None], g[None, :]),
            *((u[:-1], u[1:]), (u[1:], u[:-1])),
        ]
        self._has_state_rates = bool(problem.costs.state_rates.any())
        if self._has_state_rates:
            pairs += [(x[:-1], x[1:]), (x[1:], x[:-1])]
        rows, columns = zip(*(np.broadcast_arrays(*pair) for pair in pairs), strict=True)
        self._pattern = SparsePattern(list(rows), list(columns), (size, size))

    def blocks(self, t: CostTerms) -> FloatArray:
        """Return the scaled blocks of the cost without costs of rates, shape (N + 1, nz, nz)."""
        N, nx, nz = self._N, self._nx, self._width
        weights = self._problem.parameters.weights
        width = len(self._scale)
        blocks = np.zeros((N + 1, width, width))
        blocks[:, :nx, :nx] = t.dense
        diagonals = np.einsum("kii->ki", blocks)  # a view of the diagonals
        diagonals[:, :nx] += t.xx
        diagonals[:N, nx:nz] = t.uu
        diagonals[:, :nz] -= self._of_rates(t)
        diagonals[0, nz : nz + len(weights)] = 2.0 * weights
        if self._problem.is_free_time:
            diagonals[0, -1] = t.tt
            blocks[:, :nx, -1] = blocks[:, -1, :nx] = t.xt
            blocks[:N, nx:nz, -1] = blocks[:N, -1, nx:nz] = t.ut
        return np.asarray(blocks * (self._scale[:, None] * self._scale))

    def _of_rates(self, t: CostTerms) -> FloatArray:
        """Return the diagonals of the costs of rates, shape (N + 1, nx + nu)."""
        nx, nz = self._nx, self._width
        diagonals = np.zeros((self._N + 1, nz))
        for couplings, columns in ((t.xv, slice(0, nx)), (t.uv, slice(nx, nz))):
            diagonals[: len(couplings), columns] -= couplings
            diagonals[1 : len(couplings) + 1, columns] -= couplings
        return diagonals

    def matrix(
        self, blocks: FloatArray, t: CostTerms, per_cost: float, damping: float
    ) -> csc_matrix:
        """Return the Hessian of blocks and costs of rates, with a number added to its diagonal."""
        N, nx, nz = self._N, self._nx, self._width
        scale = self._scale[:nz]
        blocks, squares = blocks.copy(), per_cost * scale**2
        diagonals = np.einsum("kii->ki", blocks)
        diagonals[:, :nz] += self._of_rates(t) * squares + damping
        diagonals[0, nz:] += damping
        ng = diagonals.shape[1] - nz
        across = np.concatenate([blocks[:N, :nz, nz:].reshape(N * nz, ng), blocks[N, :nx, nz:]])
        parts = [blocks[:N, :nz, :nz], blocks[N, :nx, :nx], across, across]
        parts += [blocks[:, nz:, nz:].sum(axis=0), *[t.uv * squares[nx:]] * 2]
        if self._has_state_rates:
            parts += [t.xv * squares[:nx]] * 2
        return self._pattern.fill(*parts)
