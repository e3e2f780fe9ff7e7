"""Force distributions by linear programs: minimum sum, minimum peak, maximum distance to limits."""

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

# Relaxation of the distance found by a linear program, so that the following QP is feasible.
_RELAXATION = 1e-9


@distribution()
def linear_programme(poses: Poses, *, costs: ArrayLike = 1.0) -> FloatArray:
    """Minimise the cost c'f, by default the sum of forces.

    The method corresponds to `IDSolverLinProg` of CASPR. The solution is a vertex of the feasible
    set, so that forces may jump along a motion.

    Args:
        poses: Poses of a robot with any number of muscles.
        costs: c, a number or shape (m,), in [1/N], not negative.

    Raises:
        InputError: A cost is negative or not finite.
    """
    c = named_vector("costs", costs, [f"muscle {k + 1}" for k in range(poses.m)])
    return _solve_poses(poses, partial(solve_linear, c))


@distribution()
def minimum_infinity_norm(poses: Poses, *, counts: ArrayLike = 1.0) -> FloatArray:
    """Minimise the largest force.

    The method corresponds to `IDSolverMinInfNorm` of CASPR. The largest force is unique, but the
    other forces often are not. The solution with the minimum sum of squares is returned.

    Args:
        poses: Poses of a robot with any number of muscles.
        counts: Non-negative weight of each force, a number or shape (m,). A force with weight 0 is
            ignored.

    Raises:
        InputError: A weight is negative or not finite.
    """
    c = named_vector("counts", counts, [f"muscle {k + 1}" for k in range(poses.m)])
    return _solve_poses(poses, partial(_minimize_largest, weights=c))


@distribution(finite_bounds=True)
def optimally_safe(poses: Poses, *, alpha: float = 1.0) -> FloatArray:
    """Maximise the distance s to the force limits, f_min + s <= f <= f_max - alpha s.

    Borgstrom et al., "Rapid computation of optimally safe tension distributions for parallel
    cable-driven robots", IEEE Trans. Robotics 25 (2009); `IDSolverOptimallySafe` of CASPR. The
    distance s is unique. Among all forces with this distance, those nearest to the mean of the
    limits are returned.

    Args:
        poses: Poses with finite upper limits.
        alpha: Weight of the distance to the upper limit, not negative.

    Raises:
        InputError: alpha is negative or not finite.
    """
    if not (is_finite(alpha) and alpha >= 0):
        raise InputError(f"alpha must be finite and not negative: {alpha}")
    first = _solve_poses(poses, partial(_maximize_distance, alpha=alpha))
    distance = np.min(first - poses.f_min, axis=1, keepdims=True)
    if alpha > 0:
        above = np.min(poses.f_max - first, axis=1, keepdims=True)
        distance = np.minimum(distance, above / alpha)
    distance = np.maximum(distance - _RELAXATION * poses.f_max.max(axis=1, keepdims=True), 0.0)
    low, high = poses.f_min + distance, poses.f_max - alpha * distance
    return _refine(poses, first, low, np.maximum(low, high), poses.middle)


def _minimize_largest(
    A: FloatArray, b: FloatArray, low: FloatArray, high: FloatArray, weights: FloatArray
) -> FloatArray | None:
    """Return the f of min max(weights f) s.t. A f = b, low <= f <= high.

    If several solutions exist, return the one with the minimum sum of squares.
    """
    newton = DualNewton(low.size, b.size)
    newton.A[...], newton.b[:], newton.lb[:], newton.ub[:] = A, b, low, high
    newton.H_diagonal[:], newton.g[:], newton.softness[:] = 1.0, 0.0, 0.0
    if newton.solve() != SOLVED:
        return None
    target = np.zeros(low.size)
    status = newton.minimize_largest(low, high, weights, target, newton.x.copy())
    return newton.x.copy() if status == SOLVED else None


def _maximize_distance(
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


def _solve_poses(
    poses: Poses,
    solve: Callable[[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray | None],
) -> FloatArray:
    """Solve a linear program for each pose; shape (P, m), NaN if infeasible."""
    forces = np.full((len(poses.L), poses.m), np.nan)
    for k, problem in enumerate(zip(poses.A, poses.tau, poses.f_min, poses.f_max, strict=True)):
        answer = solve(*problem)
        if answer is not None:
            forces[k] = answer
    return forces


def _refine(
    poses: Poses, first: FloatArray, low: FloatArray, high: FloatArray, target: FloatArray
) -> FloatArray:
    """Return the forces nearest to a target within tighter limits, or the first solution."""
    is_solved = np.all(np.isfinite(first), axis=1)
    inner = poses._replace(f_min=low, f_max=np.maximum(low, high)).only(is_solved)
    refined = first.copy()
    better = solve_poses(inner, np.ones(poses.m), target[is_solved])
    refined[is_solved] = np.where(np.isfinite(better), better, first[is_solved])
    return refined
