"""Random QPs of all kinds that occur in controllers, and references for their solutions."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator

import numpy as np
import qpsolvers
from numpy.typing import NDArray

from controllers.arrays import FloatArray

from .box_solver import BoxProblem, BoxSolution

# Number of problems of each kind; set the variable for a thorough run.
COUNT = int(os.environ.get("CARDSFLOW_QP_PROBLEMS", "200"))


def _size(rng: np.random.Generator) -> tuple[int, int]:
    """Return numbers of variables and rows; 1 of 50 problems is as large as for a large robot."""
    if rng.random() < 0.02:
        return 80, 23
    return int(rng.integers(3, 31)), int(rng.integers(1, 11))


def _cost(rng: np.random.Generator, n: int) -> tuple[FloatArray, FloatArray]:
    H = 10.0 ** (rng.uniform(0, 4) * rng.random(n))
    return H * 10.0 ** rng.uniform(-3, 3), rng.normal(size=n) * rng.choice([0.0, 1.0, 10.0])


def _bounds(rng: np.random.Generator, n: int) -> tuple[FloatArray, FloatArray]:
    """Return bounds of forces; some variables are fixed, bounded on one side, or unbounded."""
    lb = rng.uniform(-1.0, 1.0, n) * rng.choice([0.0, 1.0, 10.0])
    ub = lb + rng.uniform(0.1, 10.0, n)
    if rng.random() < 0.5:
        kind = rng.random(n)
        ub = np.where(kind < 0.1, lb, ub)
        ub = np.where(kind > 0.8, np.inf, ub)
        lb = np.where(kind > 0.9, -np.inf, lb)
    return lb, ub


def _rows(rng: np.random.Generator, m_eq: int, n: int) -> FloatArray:
    """Return rows of different scales, as for rad and m, sometimes with columns of zeros."""
    A = rng.normal(size=(m_eq, n)) * 10.0 ** rng.uniform(-2, 2, (m_eq, 1))
    if rng.random() < 0.2:
        A[rng.random((m_eq, n)) < 0.5] = 0.0
    return A


def _inside(
    rng: np.random.Generator, lb: FloatArray, ub: FloatArray, at_bounds: float
) -> FloatArray:
    """Return a point within the bounds; a share of its variables is at a bound."""
    low = np.where(np.isfinite(lb), lb, -10.0)
    high = np.where(np.isfinite(ub), ub, np.maximum(low, 0.0) + 10.0)
    x = rng.uniform(low, high)
    pinned = rng.random(len(lb)) < at_bounds
    x = np.where(pinned & (rng.random(len(lb)) < 0.7) & np.isfinite(lb), lb, x)
    at_high = pinned & (x != lb) & np.isfinite(ub)
    return np.where(at_high, ub, x)


def feasible(seed: int) -> BoxProblem:
    """Return a problem with a solution."""
    rng = np.random.default_rng([1, seed])
    n, m_eq = _size(rng)
    (H, g), (lb, ub), A = _cost(rng, n), _bounds(rng, n), _rows(rng, m_eq, n)
    return BoxProblem(H, g, A, A @ _inside(rng, lb, ub, 0.0), lb, ub)


def at_bounds(seed: int) -> BoxProblem:
    """Return a problem whose solution has 70 % or all of its variables at their bounds.

    It is built from its optimality conditions, so that the bounds are active.
    """
    rng = np.random.default_rng([2, seed])
    n, m_eq = _size(rng)
    (H, _), (lb, ub), A = _cost(rng, n), _bounds(rng, n), _rows(rng, m_eq, n)
    x = _inside(rng, lb, ub, 1.0 if rng.random() < 0.1 else 0.7)
    push = np.abs(rng.normal(size=n)) * H * rng.choice([1e-3, 1.0, 10.0])
    sign = np.where(x == lb, 1.0, np.where(x == ub, -1.0, 0.0))
    y = rng.normal(size=m_eq) / np.linalg.norm(A, axis=1).clip(1e-12)
    return BoxProblem(H, A.T @ y + sign * push - H * x, A, A @ x, lb, ub)


def rank_deficient(seed: int) -> BoxProblem:
    """Return a problem with a solution and dependent, repeated or zero rows."""
    rng = np.random.default_rng([3, seed])
    n, m_eq = _size(rng)
    (H, g), (lb, ub) = _cost(rng, n), _bounds(rng, n)
    rank = int(rng.integers(1, min(n, m_eq) + 1))
    scale = 10.0 ** rng.uniform(-2, 2, (m_eq, 1))
    A = scale * (rng.normal(size=(m_eq, rank)) @ rng.normal(size=(rank, n)))
    if m_eq > 1 and rng.random() < 0.5:
        A[-1] = A[0] * rng.choice([0.0, 1.0, -3.0])
    return BoxProblem(H, g, A, A @ _inside(rng, lb, ub, rng.choice([0.0, 0.7])), lb, ub)


def infeasible(seed: int) -> BoxProblem:
    """Return an infeasible problem: it exceeds the bounds in a direction, by much or by little."""
    rng = np.random.default_rng([4, seed])
    n, m_eq = _size(rng)
    (H, g), (lb, ub), A = _cost(rng, n), _bounds(rng, n), _rows(rng, m_eq, n)
    norms = np.linalg.norm(A, axis=1)
    unit = A / np.where(norms > 0, norms, 1.0)[:, None]
    direction = rng.normal(size=m_eq)
    # An unbounded variable could reach any value, so it must not act in this direction.
    for i in np.flatnonzero(np.isinf(lb) | np.isinf(ub)):
        if np.isinf(lb[i]) or direction @ unit[:, i] > 0:
            lb[i], ub[i] = -1.0, 1.0
    farthest = np.where(unit.T @ direction > 0, ub, lb)
    x = np.where(np.isfinite(farthest), farthest, np.where(np.isfinite(lb), lb, ub))
    size = 1.0 + np.abs(unit) @ np.abs(x)
    margin = 10.0 ** rng.uniform(-5, 1) * size.max() / np.linalg.norm(direction)
    return BoxProblem(H, g, A, norms * (unit @ x + margin * direction) + (norms == 0), lb, ub)


Kind = Callable[[int], BoxProblem]

KINDS: dict[str, Kind] = {
    "feasible": feasible,
    "at_bounds": at_bounds,
    "rank_deficient": rank_deficient,
    "infeasible": infeasible,
}


def problems(kind: str, count: int = COUNT) -> Iterator[BoxProblem]:
    """Yield the first `count` problems of a kind."""
    return (KINDS[kind](seed) for seed in range(count))


def reference(problem: BoxProblem, guess: BoxSolution | None = None) -> FloatArray | None:
    """Return the solution with an error below 1e-12, or None if the error is unknown.

    DAQP finds the active bounds. With these, linear equations determine the solution; they are
    refined with residuals in extended precision. The solution is returned only if it fulfils the
    optimality conditions, which are sufficient for a convex problem with any active bounds, so a
    guess of the active bounds is also tried.
    """
    P = np.diag(problem.H_diagonal)
    q = qpsolvers.Problem(P, problem.g, A=problem.A, b=problem.b, lb=problem.lb, ub=problem.ub)
    found = qpsolvers.solve_problem(q, "daqp")
    if found.found and found.x is not None:
        near = 1e-7 * (1.0 + np.abs(found.x))
        z = np.asarray(found.z_box)
        for low, high in (
            (found.x - problem.lb <= near, problem.ub - found.x <= near),
            (z < 0, z > 0),
        ):
            x = _refined(problem, low, high & ~low, -np.asarray(found.y))
            if x is not None:
                return x
    if guess is None:
        return None
    low, high = guess.x <= problem.lb, guess.x >= problem.ub
    return _refined(problem, low, high & ~low, guess.multipliers)


def _refined(
    problem: BoxProblem, low: NDArray[np.bool_], high: NDArray[np.bool_], y: FloatArray
) -> FloatArray | None:
    """Return the checked solution for given active bounds, or None."""
    long = np.longdouble
    root = np.sqrt(problem.H_diagonal)
    A = problem.A / root
    norms = np.linalg.norm(A, axis=1)
    norms[norms == 0] = 1.0
    A, b, g = A / norms[:, None], problem.b / norms, problem.g / root
    lb, ub = problem.lb * root, problem.ub * root
    free = ~(low | high)
    AF = A[:, free]
    S = np.linalg.pinv(AF @ AF.T, rcond=1e-13, hermitian=True) if free.any() else 0.0 * A @ A.T
    x = np.where(low, lb, np.where(high, ub, -g)).astype(long)
    lam = (y * norms).astype(long)
    for _ in range(8):
        rest = (b.astype(long) - A.astype(long) @ x).astype(float)
        x[free] += AF.T @ (S @ rest)
        pull = (x + g - A.T.astype(long) @ lam).astype(float)[free]
        lam += S @ (AF @ pull)
    size = np.abs(b) + np.abs(A) @ np.abs(x)
    pull = x + g - A.T @ lam
    terms = np.abs(x) + np.abs(g) + np.abs(A).T @ np.abs(lam)
    fixed = problem.lb == problem.ub
    good = (
        (np.abs(b - A @ x) <= 1e-13 * size).all()
        and (np.maximum(lb - x, x - ub) <= 1e-12 * (1 + np.abs(x))).all()
        and (np.abs(pull[free]) <= 1e-12 * terms[free]).all()
        and (pull[low & ~fixed] >= -1e-12 * terms[low & ~fixed]).all()
        and (pull[high & ~fixed] <= 1e-12 * terms[high & ~fixed]).all()
    )
    return np.asarray(x / root, dtype=float) if good else None


def is_proof_of_infeasibility(problem: BoxProblem, y: FloatArray) -> bool:
    """Return whether y'b > y'Ax for all x within the bounds, far beyond rounding errors.

    If a bound is infinite and y'A is not exactly zero, x is assumed to be less than 100 times the
    other bounds, as in the solutions of the generated problems.
    """
    long = np.longdouble
    pull = problem.A.T.astype(long) @ y.astype(long)
    far = 100.0 * max(np.abs(v[np.isfinite(v)]).max(initial=1.0) for v in (problem.lb, problem.ub))
    bound = np.clip(np.where(pull > 0, problem.ub, problem.lb), -far, far)
    terms = np.abs(y) @ np.abs(problem.b) + np.abs(y) @ np.abs(problem.A) @ np.abs(bound)
    return bool(problem.b.astype(long) @ y - pull @ bound > 1e-13 * terms)
