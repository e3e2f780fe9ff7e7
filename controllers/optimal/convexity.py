"""Convex quadratic programs whose solution is that of a program with an indefinite Hessian."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from controllers.arrays import FloatArray, IntArray

from .qp import QuadraticProgram

_SHARES = (1.0, 0.5, 0.25)
_MIN_CURVATURE = 1e-2  # of controls, for Hessians of size 1


class ConvexStages(NamedTuple):
    """Stages of a convex program.

    Attributes:
        blocks: Hessians, for states, controls and globals, shape (N + 1, nz, nz).
        gradients: Changes of the gradients, shape (N, nz).
        moved: Hessians of states and globals that moved to the stage before, shape
            (N + 1, nx + ng, nx + ng).
    """

    blocks: FloatArray
    gradients: FloatArray
    moved: FloatArray


class Program(NamedTuple):
    """Quadratic program of a step.

    Attributes:
        qp: The program.
        moved: See `ConvexStages`; None without a contribution of the dynamics to the Hessian.
    """

    qp: QuadraticProgram
    moved: FloatArray | None


def convexify_with_share(
    blocks: FloatArray,
    added: FloatArray,
    ends: FloatArray,
    gaps: FloatArray,
    nu: int,
    free: IntArray,
) -> ConvexStages | None:
    """Return the stages of `convexify` with the largest share of added blocks, shape (N, nz, nz).

    Returns:
        The stages; None if the smallest share is not convex, since larger ones are less convex.
    """

    def convex(share: float) -> ConvexStages | None:
        shared = blocks.copy()
        shared[:-1] += share * added
        return convexify(shared, ends, gaps, nu, free)

    smallest = convex(_SHARES[-1])
    if smallest is None:
        return None
    return next(filter(None, map(convex, _SHARES[:-1])), smallest)


def convexify(
    blocks: FloatArray, ends: FloatArray, gaps: FloatArray, nu: int, free: IntArray
) -> ConvexStages | None:
    """Move the curvature of states to the controls before, by which the dynamics determine them.

    States and globals s = (x, g) follow s+ = F z + c, so that s+'V s+ and (F z + c)'V (F z + c)
    can replace each other. From the end, a stage with the Hessian V of the next one has

        M = H + F'V F,    V' = M_ss - M_su M_uu^-1 M_us.

    V' moves to the stage before. The rest is the square of u + M_uu^-1 M_us s in the norm of M_uu.

    Args:
        blocks: Hessians H of states, controls and globals, shape (N + 1, nz, nz).
        ends: Derivatives of the next states by them, shape (N, nx, nz).
        gaps: c of the states, shape (N, nx).
        nu: Number of controls.
        free: Indices of the free variables among the states of the start and the globals.

    Returns:
        The convex stages; None if an M_uu is not positive.
    """
    N, nx, nz = ends.shape
    s, u = np.r_[:nx, nx + nu : nz], slice(nx, nx + nu)
    ss, su = np.ix_(s, s), (s, u)
    F = np.zeros((N, len(s), nz))
    F[:, :nx] = ends
    F[:, range(nx, len(s)), range(nx + nu, nz)] = 1.0
    convex, gradients = np.zeros_like(blocks), np.empty((N, nz))
    moved = np.empty((N + 1, len(s), len(s)))
    V = moved[N] = blocks[N][ss]
    for k in range(N - 1, -1, -1):
        FV = F[k].T @ V
        convex[k] = M = blocks[k] + FV @ F[k]
        gradients[k] = FV[:, :nx] @ gaps[k]
        if np.linalg.eigvalsh(M[u, u])[0] < _MIN_CURVATURE:
            return None
        rest = M[su] @ np.linalg.solve(M[u, u], M[su].T)
        rest = 0.5 * (rest + rest.T)
        V = moved[k] = M[ss] - rest
        convex[k][ss] = rest
    at_start = np.ix_(s[free], s[free])
    convex[0][at_start] += positive_part(V[np.ix_(free, free)])
    return ConvexStages(convex, gradients, moved)


def positive_part(H: FloatArray) -> FloatArray:
    """Return symmetric matrices without their negative eigenvalues, shape (..., n, n)."""
    values, vectors = np.linalg.eigh(H)
    factor = vectors * np.sqrt(np.maximum(values, 0.0))[..., None, :]
    return np.asarray(factor @ factor.swapaxes(-1, -2))
