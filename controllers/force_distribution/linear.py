"""Linear programmes over the forces: least sum, least largest force, largest distance to bounds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray
from controllers.validation import is_finite, named_vector

from .feasibility import solve_linear
from .poses import DistributedForces, Poses, finish, gather, require_finite_bounds
from .quadratic import solve_poses

_WIDER = 1e-9  # how much a bound found by a linear programme is opened for the QP after it


def linear_programme(
    L: ArrayLike,
    tau: ArrayLike,
    f_min: ArrayLike,
    f_max: ArrayLike,
    *,
    costs: ArrayLike = 1.0,
) -> DistributedForces:
    """Least cost c'f, by default the least sum of forces; CASPR's `IDSolverLinProg`.

    The forces are a vertex of what is possible: along a motion they may jump.

    Args:
        L: Muscle Jacobians, shape (..., m, n), in [m/rad] or [m/m].
        tau: Wanted torques, shape (..., n), in [N·m] or [N].
        f_min: Lower bounds, a number, shape (m,) or (..., m), in [N].
        f_max: Upper bounds, likewise; may be infinite.
        costs: c, a number or shape (m,), in [1/N], not negative.

    Raises:
        InputError: A size or a number is wrong.
    """
    poses = gather(L, tau, f_min, f_max)
    c = named_vector("costs", costs, [f"muscle {k + 1}" for k in range(poses.m)])

    def solve(A: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray | None:
        return solve_linear(c, A, b, low, high)

    return finish(poses, "linear_programme", _each(poses, solve))


def minimum_infinity_norm(
    L: ArrayLike, tau: ArrayLike, f_min: ArrayLike, f_max: ArrayLike
) -> DistributedForces:
    """Least largest force: the strongest muscle is as weak as can be; CASPR's `IDSolverMinInfNorm`.

    The largest force is unique, the others often are not: of all answers it is the one of least
    squares.

    Args:
        L: Muscle Jacobians, shape (..., m, n), in [m/rad] or [m/m].
        tau: Wanted torques, shape (..., n), in [N·m] or [N].
        f_min: Lower bounds, a number, shape (m,) or (..., m), in [N].
        f_max: Upper bounds, likewise; may be infinite.

    Raises:
        InputError: A size or a number is wrong.
    """
    poses = gather(L, tau, f_min, f_max)
    first = _each(poses, _smallest_largest)
    cap = (1.0 + _WIDER) * first.max(axis=1, keepdims=True)
    refined = _refined(poses, first, poses.f_min, np.minimum(poses.f_max, cap), 0.0 * first)
    return finish(poses, "minimum_infinity_norm", refined)


def optimally_safe(
    L: ArrayLike,
    tau: ArrayLike,
    f_min: ArrayLike,
    f_max: ArrayLike,
    *,
    alpha: float = 1.0,
) -> DistributedForces:
    """Largest s with f_min + s <= f <= f_max - alpha s: as far from the bounds as can be.

    Borgstrom et al., "Rapid computation of optimally safe tension distributions for parallel
    cable-driven robots", IEEE Trans. Robotics 25 (2009); CASPR's `IDSolverOptimallySafe`. The
    distance s is unique; of all forces that keep it, these are the nearest to the middle.

    Args:
        L: Muscle Jacobians, shape (..., m, n), in [m/rad] or [m/m].
        tau: Wanted torques, shape (..., n), in [N·m] or [N].
        f_min: Lower bounds, a number, shape (m,) or (..., m), in [N].
        f_max: Upper bounds, likewise; finite.
        alpha: How much the upper bound counts beside the lower one, not negative.

    Raises:
        InputError: A size or a number is wrong, or a muscle has no upper bound.
    """
    if not (is_finite(alpha) and alpha >= 0):
        raise InputError(f"alpha must be finite and not negative: {alpha}")
    poses = gather(L, tau, f_min, f_max)
    require_finite_bounds(poses, "optimally_safe")

    def solve(A: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray | None:
        return _safest(A, b, low, high, alpha)

    first = _each(poses, solve)
    distance = np.min(first - poses.f_min, axis=1, keepdims=True)
    if alpha > 0:
        above = np.min(poses.f_max - first, axis=1, keepdims=True)
        distance = np.minimum(distance, above / alpha)
    distance = np.maximum(distance - _WIDER * poses.f_max.max(axis=1, keepdims=True), 0.0)
    low, high = poses.f_min + distance, poses.f_max - alpha * distance
    middle = 0.5 * (poses.f_min + poses.f_max)
    refined = _refined(poses, first, low, np.maximum(low, high), middle)
    return finish(poses, "optimally_safe", refined)


def _smallest_largest(
    A: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray | None:
    """The f of min t s.t. A f = b, low <= f <= min(high, t)."""
    n, m = A.shape
    x = solve_linear(
        np.append(np.zeros(m), 1.0),
        np.c_[A, np.zeros(n)],
        b,
        np.append(low, 0.0),
        np.append(high, np.inf),
        np.c_[np.eye(m), -np.ones(m)],
        np.zeros(m),
    )
    return None if x is None else x[:m]


def _safest(
    A: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray, alpha: float
) -> FloatArray | None:
    """The f of max s s.t. A f = b, low + s <= f <= high - alpha s, s >= 0."""
    n, m = A.shape
    x = solve_linear(
        np.append(np.zeros(m), -1.0),
        np.c_[A, np.zeros(n)],
        b,
        np.append(low, 0.0),
        np.append(high, float((high - low).max())),
        np.vstack([np.c_[-np.eye(m), np.ones(m)], np.c_[np.eye(m), np.full(m, alpha)]]),
        np.append(-low, high),
    )
    return None if x is None else x[:m]


def _each(
    poses: Poses,
    solve: Callable[[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray | None],
) -> FloatArray:
    """What a linear programme says pose by pose, shape (P, m); NaN where it says nothing."""
    forces = np.full((len(poses.L), poses.m), np.nan)
    for k, problem in enumerate(zip(poses.A, poses.tau, poses.f_min, poses.f_max, strict=True)):
        answer = solve(*problem)
        if answer is not None:
            forces[k] = answer
    return forces


def _refined(
    poses: Poses, first: FloatArray, low: FloatArray, high: FloatArray, target: FloatArray
) -> FloatArray:
    """The forces nearest to a target within tighter bounds; the first answer where that fails."""
    found = np.all(np.isfinite(first), axis=1)
    inner = poses._replace(f_min=low, f_max=np.maximum(low, high)).only(found)
    refined = first.copy()
    better = solve_poses(inner, np.ones(poses.m), target[found])
    refined[found] = np.where(np.isfinite(better), better, first[found])
    return refined
