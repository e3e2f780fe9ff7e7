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
from scipy.linalg import LinAlgError, cho_factor, cho_solve, cho_solve_banded, cholesky_banded
from scipy.sparse.csgraph import connected_components

from controllers.arrays import FloatArray

_BAND = 2  # distance of coupled unknowns of a muscle


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
        used = abs(L).max(axis=0) > 0.0
        self._used = [np.flatnonzero(row) for row in used]
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
        constant = equations.B[:, :, 1] * equations.t
        right = np.zeros((m, N + 1, N + 1))
        k = np.arange(N)
        right[:, k, k], right[:, k + 1, k] = pull[:, :, 0], pull[:, :, 1]
        right[:, :, N] = self._gradient(equations)
        Z = cho_solve_banded((factor, True), right.reshape(-1, N + 1), check_finite=False)
        Z = Z.reshape(m, N + 1, N + 1)
        response = pull[:, :, 0, None] * Z[:, :-1] + pull[:, :, 1, None] * Z[:, 1:]
        tension = constant - response[:, :, N]
        load = equations.c + np.einsum("kmn,mk->kn", self._L, tension)
        y = self._multipliers(response[:, :, :N], equations.D, load)
        if y is None:
            return None
        pulls = np.einsum("kmn,kn->mk", self._L, y)
        x = -Z[:, :, N] - np.matmul(Z[:, :, :N], pulls[:, :, None])[:, :, 0]
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
        N, n = self._N, self._n
        S = np.zeros((n, n, N, N))
        for m, used in enumerate(self._used):
            arms = self._L[:, m, used]
            for i, row in enumerate(used):
                left = arms[:, i, None] * response[m]
                for j, column in enumerate(used):
                    S[row, column] += left * arms[:, j]
        y = np.empty((N, n))
        for group in self._groups:
            size = N * len(group)
            block = S[np.ix_(group, group)].transpose(0, 2, 1, 3).reshape(size, size)
            block[np.diag_indices(size)] += D[:, group].T.ravel()
            try:
                factor = cho_factor(block, lower=True, overwrite_a=True, check_finite=False)
            except LinAlgError:
                return None
            y[:, group] = cho_solve(factor, load[:, group].T.ravel()).reshape(len(group), N).T
        return y
