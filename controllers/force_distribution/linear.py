"""Linear programmes over the forces: least sum, least largest force, largest distance to bounds."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray
from controllers.qp.dual_newton import SOLVED, DualNewton
from controllers.validation import is_finite, named_vector

from .feasibility import solve_linear
from .poses import Poses, distribution
from .quadratic import solve_poses

_WIDER = 1e-9  # how much a bound found by a linear programme is opened for the QP after it


@distribution()
def linear_programme(poses: Poses, *, costs: ArrayLike = 1.0) -> FloatArray:
    """Least cost c'f, by default the least sum of forces; CASPR's `IDSolverLinProg`.

    The forces are a vertex of what is possible: along a motion they may jump.

    Args:
        poses: Of any number of muscles.
        costs: c, a number or shape (m,), in [1/N], not negative.

    Raises:
        InputError: A cost is negative or not finite.
    """
    c = named_vector("costs", costs, [f"muscle {k + 1}" for k in range(poses.m)])
    return _each(poses, partial(solve_linear, c))


@distribution()
def minimum_infinity_norm(poses: Poses, *, counts: ArrayLike = 1.0) -> FloatArray:
    """Least largest force: the strongest muscle is as weak as can be; CASPR's `IDSolverMinInfNorm`.

    The largest force is unique, the others often are not: of all answers it is the one of least
    squares.

    Args:
        poses: Of any number of muscles.
        counts: How much each force counts, a number or shape (m,), not negative: 0 for none.

    Raises:
        InputError: One is negative or not finite.
    """
    c = named_vector("counts", counts, [f"muscle {k + 1}" for k in range(poses.m)])
    return _each(poses, partial(_least_largest, counts=c))


@distribution(finite_bounds=True)
def optimally_safe(poses: Poses, *, alpha: float = 1.0) -> FloatArray:
    """Largest s with f_min + s <= f <= f_max - alpha s: as far from the bounds as can be.

    Borgstrom et al., "Rapid computation of optimally safe tension distributions for parallel
    cable-driven robots", IEEE Trans. Robotics 25 (2009); CASPR's `IDSolverOptimallySafe`. The
    distance s is unique; of all forces that keep it, these are the nearest to the middle.

    Args:
        poses: With finite upper bounds.
        alpha: How much the upper bound counts next to the lower one, not negative.

    Raises:
        InputError: alpha is negative or not finite.
    """
    if not (is_finite(alpha) and alpha >= 0):
        raise InputError(f"alpha must be finite and not negative: {alpha}")
    first = _each(poses, partial(_safest, alpha=alpha))
    distance = np.min(first - poses.f_min, axis=1, keepdims=True)
    if alpha > 0:
        above = np.min(poses.f_max - first, axis=1, keepdims=True)
        distance = np.minimum(distance, above / alpha)
    distance = np.maximum(distance - _WIDER * poses.f_max.max(axis=1, keepdims=True), 0.0)
    low, high = poses.f_min + distance, poses.f_max - alpha * distance
    return _refined(poses, first, low, np.maximum(low, high), poses.middle)


def _least_largest(
    A: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray, counts: FloatArray
) -> FloatArray | None:
    """The f of min max counts f, A f = b, low <= f <= high: of several that of least squares."""
    newton = DualNewton(low.size, b.size)
    newton.A[...], newton.b[:], newton.lb[:], newton.ub[:] = A, b, low, high
    newton.H_diagonal[:], newton.g[:], newton.softness[:] = 1.0, 0.0, 0.0
    if newton.solve() != SOLVED:
        return None
    nothing = np.zeros(low.size)
    status = newton.least_largest(low, high, counts, nothing, newton.x.copy())
    return newton.x.copy() if status == SOLVED else None


def _safest(
    A: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray, alpha: float
) -> FloatArray | None:
    """Return the f of max s s.t. A f = b, low + s <= f <= high - alpha s, s >= 0."""
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
    """Solutions of a linear programme pose by pose, shape (P, m); NaN if there is none."""
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
