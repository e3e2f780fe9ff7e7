"""Convex programs with the solution of an indefinite one, and secant Hessians of the dynamics."""

from __future__ import annotations

import numpy as np

from controllers.optimal.convexity import convexify
from controllers.optimal.lagrangian import DynamicsHessian

N, NX, NU, NG = 6, 3, 2, 1
WIDTH = NX + NU + NG
RNG = np.random.default_rng(3)


def symmetric(size: int) -> np.ndarray:
    own = RNG.normal(size=(size, size))
    return own + own.T


def solution(
    blocks: np.ndarray, gradients: np.ndarray, ends: np.ndarray, gaps: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return x, u, g and multipliers of the ends by the conditions of optimality; x0 is 0."""
    stage = NX + NU
    size = N * stage + NX + NG
    H, g = np.zeros((size, size)), np.zeros(size)
    A, b = np.zeros(((N + 1) * NX, size)), np.zeros((N + 1) * NX)
    for k in range(N + 1):
        at = np.r_[k * stage : min((k + 1) * stage, size - NG), size - NG : size]
        own = np.r_[: len(at) - NG, stage : stage + NG]
        H[np.ix_(at, at)] += blocks[k][np.ix_(own, own)]
        if k < N:
            g[at] += gradients[k]
            rows, after = slice(k * NX, (k + 1) * NX), (k + 1) * stage + np.arange(NX)
            A[rows, at], A[rows, after], b[rows] = ends[k], -np.eye(NX), -gaps[k]
    A[N * NX :, :NX] = np.eye(NX)
    rows = len(b)
    both = np.linalg.solve(np.block([[H, A.T], [A, np.zeros((rows, rows))]]), np.append(-g, b))
    return both[:size], both[size:][: N * NX].reshape(N, NX)


def test_convex_program_has_the_solution_and_multipliers_of_the_indefinite_one() -> None:
    ends, gaps = 0.3 * RNG.normal(size=(N, NX, WIDTH)), RNG.normal(size=(N, NX))
    blocks = np.array([symmetric(WIDTH) for _ in range(N + 1)])
    blocks[:, NX : NX + NU, NX : NX + NU] += 30.0 * np.eye(NU)
    blocks[0, -NG:, -NG:] += 30.0
    assert np.linalg.eigvalsh(blocks).min() < -1.0
    gradients = RNG.normal(size=(N, WIDTH))
    found = convexify(blocks, ends, gaps, NU, np.array([NX]))
    assert found is not None
    assert np.linalg.eigvalsh(found.blocks).min() > -1e-9
    own, y = solution(blocks, gradients, ends, gaps)
    convex, moved_y = solution(found.blocks, gradients + found.gradients, ends, gaps)
    np.testing.assert_allclose(convex, own, atol=1e-9)
    x = own[:-NG].reshape(-1)[[k * (NX + NU) + i for k in range(N + 1) for i in range(NX)]]
    s = np.concatenate([x.reshape(N + 1, NX), np.tile(own[-NG:], (N + 1, 1))], axis=1)
    moved = np.einsum("kij,kj->ki", found.moved, s)[1:, :NX]
    np.testing.assert_allclose(moved_y + moved, y, atol=1e-7)


def test_program_without_a_minimum_is_not_made_convex() -> None:
    blocks = np.zeros((N + 1, WIDTH, WIDTH))
    blocks[:, NX : NX + NU, NX : NX + NU] = -np.eye(NU)
    nothing = np.zeros((N, NX, WIDTH)), np.zeros((N, NX))
    assert convexify(blocks, *nothing, NU, np.array([NX])) is None


def test_secants_of_independent_steps_are_the_hessian() -> None:
    exact = np.array([symmetric(4) for _ in range(5)])
    own = DynamicsHessian(5, 4)
    for step in RNG.normal(size=(4, 5, 4)):
        own.update(step, np.einsum("kij,kj->ki", exact, step))
    np.testing.assert_allclose(own.blocks, exact, atol=1e-8)
