"""Linear equations of muscles along a motion, which are coupled by the torques at each frame.

The unknowns of a muscle over N frames are x_0 ... x_N between and around the frames, and the
activations a_k = t_k + T_k (x_before, x_after) at the frames. Each muscle only depends on its own
neighbours in time, so that the matrix K of all muscles has a narrow band. With the derivatives B of
the torques, and a diagonal D, the equations are

    K d + B'y = -g,   B d - D y = -c.

K is factorised once. The equations of y are dense in time, and are solved separately for each set
of coordinates that muscles couple.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, cho_solve, cho_solve_banded, cholesky_banded
from scipy.sparse.csgraph import connected_components

from controllers.arrays import FloatArray

_BAND = 2  # distance of coupled unknowns of a muscle
_BLOCK = 64  # rows of blocks of dense factorisations


class ChainEquations(NamedTuple):
    """Equations of m muscles over N frames.

    Attributes:
        frames: Symmetric blocks of (x before, a, x after) at each frame, shape (m, N, 3, 3).
        edges: Symmetric blocks of (a, next a), shape (m, N - 1, 2, 2).
        T: Derivatives of a by (x before, x after), shape (m, N, 2).
        t: Constant parts of a, shape (m, N).
        B: Derivatives of the tension by (x before, a, x after), shape (m, N, 3), in [N].
        D: Shape (N, n).
        g_x: Right-hand side of x, shape (m, N + 1).
        g_a: Right-hand side of a, shape (m, N).
        c: Right-hand side of the torques, shape (N, n).
    """

    frames: FloatArray
    edges: FloatArray
    T: FloatArray
    t: FloatArray
    B: FloatArray
    D: FloatArray
    g_x: FloatArray
    g_a: FloatArray
    c: FloatArray


class ChainSolution(NamedTuple):
    """Solution of the equations.

    Attributes:
        x: Shape (m, N + 1).
        a: Shape (m, N).
        y: Multipliers of the torques, shape (N, n).
        a_residual: Left-hand side minus right-hand side of a, without y, shape (m, N).
    """

    x: FloatArray
    a: FloatArray
    y: FloatArray
    a_residual: FloatArray


class MuscleChains:
    """Solver of the equations for given muscle Jacobians.

    Args:
        L: Muscle Jacobians of the n coordinates, shape (N, m, n).
    """

    def __init__(self, L: FloatArray) -> None:
        self._L = L
        self._N, self._m, self._n = L.shape
        self._used = used = abs(L).max(axis=0) > 0.0
        count, label = connected_components(used.T.astype(int) @ used.astype(int), directed=False)
        self._groups = [np.flatnonzero(label == k) for k in range(count)]

    def solve(self, equations: ChainEquations) -> ChainSolution | None:
        """Return the solution; None if the equations have no unique minimum."""
        N, m, T = self._N, self._m, equations.T
        try:
            factor = cholesky_banded(self._band(equations), lower=True, check_finite=False)
        except LinAlgError:
            return None
        # derivatives of the tension by x before and after
        pull = equations.B[:, :, ::2] + equations.B[:, :, 1, None] * T
        gradient, factors = self._gradient(equations), (factor, True)
        x = -cho_solve_banded(factors, gradient.ravel(), check_finite=False).reshape(m, N + 1)
        tension = equations.B[:, :, 1] * equations.t
        tension += pull[:, :, 0] * x[:, :-1] + pull[:, :, 1] * x[:, 1:]
        load = equations.c + np.einsum("kmn,mk->kn", self._L, tension)
        response = _responses(factor.reshape(-1, m, N + 1), pull)
        y = self._multipliers(response, equations.D, load)
        if y is None:
            return None
        pulls = pull * np.einsum("kmn,kn->mk", self._L, y)[:, :, None]
        gradient[:, :-1] += pulls[:, :, 0]
        gradient[:, 1:] += pulls[:, :, 1]
        x = -cho_solve_banded(factors, gradient.ravel(), check_finite=False).reshape(m, N + 1)
        a = equations.t + T[:, :, 0] * x[:, :-1] + T[:, :, 1] * x[:, 1:]
        return ChainSolution(x, a, y, self._rows_of_a(equations, x, a))

    def _rows_of_a(self, equations: ChainEquations, x: FloatArray, a: FloatArray) -> FloatArray:
        """Return the left-hand side of the equations of a, plus g_a."""
        g_a, H, E = equations.g_a, equations.frames, equations.edges
        rows = g_a + H[:, :, 1, 0] * x[:, :-1] + H[:, :, 1, 1] * a + H[:, :, 1, 2] * x[:, 1:]
        rows[:, :-1] += E[:, :, 0, 0] * a[:, :-1] + E[:, :, 0, 1] * a[:, 1:]
        rows[:, 1:] += E[:, :, 1, 0] * a[:, :-1] + E[:, :, 1, 1] * a[:, 1:]
        return np.asarray(rows)

    def _gradient(self, equations: ChainEquations) -> FloatArray:
        """Return g, with a replaced by x."""
        g = equations.g_x.copy()
        rows = self._rows_of_a(equations, np.zeros_like(g), equations.t)
        g[:, :-1] += equations.frames[:, :, 0, 1] * equations.t + equations.T[:, :, 0] * rows
        g[:, 1:] += equations.frames[:, :, 2, 1] * equations.t + equations.T[:, :, 1] * rows
        return g

    def _band(self, equations: ChainEquations) -> FloatArray:
        """Return K, with a replaced by x, as a lower band matrix of LAPACK."""
        band = np.zeros((_BAND + 1, self._m, self._N + 1))
        M = np.zeros((self._m, self._N, 3, 2))  # (x before, a, x after) by (x before, x after)
        M[:, :, 0, 0] = M[:, :, 2, 1] = 1.0
        M[:, :, 1] = equations.T
        H = np.swapaxes(M, 2, 3) @ equations.frames @ M
        band[0, :, :-1] += H[:, :, 0, 0]
        band[0, :, 1:] += H[:, :, 1, 1]
        band[1, :, :-1] += H[:, :, 1, 0]
        M = np.zeros((self._m, self._N - 1, 2, 3))  # (a, next a) by three x
        M[:, :, 0, :2], M[:, :, 1, 1:] = equations.T[:, :-1], equations.T[:, 1:]
        H = np.swapaxes(M, 2, 3) @ equations.edges @ M
        for i in range(3):
            for j in range(i + 1):
                band[i - j, :, j : self._N - 1 + j] += H[:, :, i, j]
        return band.reshape(_BAND + 1, -1)

    def _multipliers(
        self, response: FloatArray, D: FloatArray, load: FloatArray
    ) -> FloatArray | None:
        """Solve (B K^-1 B' + D) y = load."""
        N, y = self._N, np.empty((self._N, self._n))
        for group in self._groups:
            size = N * len(group)
            block = np.zeros((size, size))
            for i, row in enumerate(group):
                for j, column in enumerate(group[: i + 1]):
                    part = block[i * N : (i + 1) * N, j * N : (j + 1) * N]
                    for m in np.flatnonzero(self._used[:, row] & self._used[:, column]):
                        moved = response[m] * self._L[:, m, row, None]
                        moved *= self._L[:, m, column]
                        part += moved
            block[np.diag_indices(size)] += D[:, group].T.ravel()
            try:
                _factorise(block)
            except LinAlgError:
                return None
            solution = cho_solve((block, True), load[:, group].T.ravel(), check_finite=False)
            y[:, group] = solution.reshape(len(group), N).T
        return y


def _factorise(A: FloatArray) -> None:
    """Replace the lower triangle of a positive definite matrix by its Cholesky factor.

    `scipy.linalg.cho_factor` needs up to 20 times as much processor time if BLAS has several
    threads and processors are busy. BLAS multiplies blocks of this size in one thread.
    """
    blocks = [slice(k, min(k + _BLOCK, len(A))) for k in range(0, len(A), _BLOCK)]
    for k, done in enumerate(blocks):
        A[done, done] = np.linalg.cholesky(A[done, done])
        inverse = np.linalg.inv(A[done, done]).T
        for i, rows in enumerate(blocks[k + 1 :], k + 1):
            A[rows, done] = A[rows, done] @ inverse
            for columns in blocks[k + 1 : i + 1]:
                A[rows, columns] -= A[rows, done] @ A[columns, done].T


def _responses(factor: FloatArray, pull: FloatArray) -> FloatArray:
    """Return b K^-1 b' of each muscle, shape (m, N, N).

    These matrices are symmetric; the recursions along time only compute their lower triangles.

    Args:
        factor: Cholesky factor of K as diagonals, shape (3, m, N + 1).
        pull: Derivatives b of the tension by (x before, x after), shape (m, N, 2).
    """
    m, N, _ = pull.shape
    diagonal, near, far = factor.transpose(0, 2, 1)[..., None]
    b, Z = pull.transpose(2, 1, 0)[..., None], np.zeros((N + 3, m, N))
    for k in range(N + 1):
        Z[k, :, k : k + 1] += b[0, k] if k < N else 0.0
        Z[k, :, k - 1 : k] += b[1, k - 1] if k else 0.0
        if k > 0:
            Z[k, :, :k] -= near[k - 1] * Z[k - 1, :, :k]
        if k > 1:
            Z[k, :, : k - 1] -= far[k - 2] * Z[k - 2, :, : k - 1]
        Z[k, :, : k + 1] /= diagonal[k]
    response = np.empty((m, N, N))
    for k in range(N, -1, -1):
        row = Z[k, :, : k + 1]
        row -= near[k] * Z[k + 1, :, : k + 1]
        row -= far[k] * Z[k + 2, :, : k + 1]
        row /= diagonal[k]
        if k < N:
            row_of_tension = b[0, k] * row + b[1, k] * Z[k + 1, :, : k + 1]
            response[:, k, : k + 1] = response[:, : k + 1, k] = row_of_tension
    return response
