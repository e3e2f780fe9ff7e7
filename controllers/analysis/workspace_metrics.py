"""Workspace metrics of CASPR, for one pose or a stack of poses.

All functions require muscle Jacobians L, shape (..., m, n), in [m/rad] or [m/m]. They raise
InputError for another shape and for values that are not finite.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from controllers.arrays import FloatArray
from controllers.force_distribution.feasibility import solve_linear
from controllers.force_distribution.poses import Poses, gather
from controllers.qp.dual_newton import SOLVED, DualNewton

from .wrench_set import full_rank


def condition_number(L: ArrayLike) -> FloatArray:
    """Return the smallest divided by the largest singular value of L, shape (...).

    The result is between 0 (singular) and 1 (isotropic). It corresponds to `ConditionNumberMetric`
    of CASPR, and is the inverse of the usual condition number.
    """
    poses = _poses(L)
    if poses.m < poses.n:
        return np.zeros(poses.stack)
    s = np.linalg.svd(poses.L, compute_uv=False)
    largest = np.where(s[:, 0] > 0, s[:, 0], 1.0)
    return np.asarray((s[:, -1] / largest).reshape(poses.stack))


def tension_factor(L: ArrayLike) -> FloatArray:
    """Return the largest ratio min f / max f of forces that produce zero torque, shape (...).

    The result is between 0 (no wrench closure) and 1 (equal forces). Pham, Yeo, Yang, Chen,
    "Workspace analysis of fully restrained cable-driven manipulators", Robotics and Autonomous
    Systems 57 (2009). `TensionFactorMetric` of CASPR uses the solution with the minimum sum of
    forces. It is equal for m = n + 1 muscles, and smaller for more muscles.
    """
    poses = _poses(L)
    m, factors = poses.m, np.zeros(len(poses.L))
    rows = np.c_[-np.eye(m), np.ones(m)]  # t - f_i <= 0
    for k in np.flatnonzero(full_rank(poses.L)):
        x = solve_linear(
            np.append(np.zeros(m), -1.0),
            np.c_[poses.A[k], np.zeros(poses.n)],
            np.zeros(poses.n),
            np.zeros(m + 1),
            np.ones(m + 1),
            rows,
            np.zeros(m),
        )
        factors[k] = 0.0 if x is None else x[m]
    return factors.reshape(poses.stack)


def unilateral_dexterity(L: ArrayLike) -> FloatArray:
    """Return the dexterity with muscles that only pull, shape (...).

    The result is between 0 (no wrench closure) and 1. It is sqrt(m + 1) · (smallest / largest
    singular value) · h / sqrt(h² + 1). Here, h is the smallest entry of the unit vector along the
    minimum forces f >= 1 that produce zero torque. The function returns the maximum over the set of
    all muscles and all sets without one muscle. Kurtz, Hayward, "Dexterity measures with unilateral
    actuation constraints: the n + 1 case", Advanced Robotics 9 (1994), extended to more muscles
    like `UnilateralDexterityMetric` of CASPR.
    """
    poses = _poses(L)
    best = _dexterity(poses.L)
    closed = best > 0
    if poses.m > poses.n + 1:
        for k in range(poses.m):
            reduced = np.delete(poses.L[closed], k, axis=1)
            best[closed] = np.maximum(best[closed], _dexterity(reduced))
    return best.reshape(poses.stack)


def _dexterity(L: FloatArray) -> FloatArray:
    """Return the dexterity of all muscles together, shape (P,)."""
    (P, m, n), values = L.shape, np.zeros(len(L))
    if not P or m < n:
        return values
    solver = DualNewton(m, n)
    solver.H_diagonal[:], solver.g[:], solver.b[:], solver.softness[:] = 1.0, 0.0, 0.0, 0.0
    solver.lb[:], solver.ub[:] = 1.0, np.inf
    condition = condition_number(L)
    for k in np.flatnonzero(full_rank(L)):
        solver.A[...] = -L[k].T
        if solver.solve() == SOLVED:
            h = solver.x.min() / np.linalg.norm(solver.x)
            values[k] = np.sqrt(m + 1.0) * condition[k] * h / np.sqrt(h**2 + 1.0)
    return values


def _poses(L: ArrayLike) -> Poses:
    return gather(L, np.zeros(np.shape(L)[-1:]), 0.0, np.inf)
