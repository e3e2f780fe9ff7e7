"""Workspace metrics of CASPR, for one pose or a stack of poses.

All take muscle Jacobians L, shape (..., m, n), in [m/rad] or [m/m], and raise InputError for
another shape or values that are not finite.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from controllers.arrays import FloatArray
from controllers.force_distribution.feasibility import solve_linear
from controllers.force_distribution.poses import Poses, gather
from controllers.qp.problem import BoxProblem
from controllers.qp.solver import BoxSolver

from .wrench_set import full_rank


def condition_number(L: ArrayLike) -> FloatArray:
    """Smallest over largest singular value of L, from 0, singular, to 1, isotropic; shape (...).

    CASPR's `ConditionNumberMetric`, which is the inverse of what is usually called so.
    """
    poses = _poses(L)
    if poses.m < poses.n:
        return np.zeros(poses.stack)
    s = np.linalg.svd(poses.L, compute_uv=False)
    largest = np.where(s[:, 0] > 0, s[:, 0], 1.0)
    return np.asarray((s[:, -1] / largest).reshape(poses.stack))


def tension_factor(L: ArrayLike) -> FloatArray:
    """Return the largest ratio min f / max f of forces that make no torque, shape (...).

    From 0, no wrench closure, to 1, all muscles alike. Pham, Yeo, Yang, Chen, "Workspace analysis
    of fully restrained cable-driven manipulators", Robotics and Autonomous Systems 57 (2009).
    CASPR's `TensionFactorMetric` takes the ratio of one solution, of least sum; that is the
    same where one muscle is to spare, and smaller otherwise.
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
    """Dexterity with muscles that only pull, from 0, no wrench closure, to 1; shape (...).

    sqrt(m + 1) · (smallest over largest singular value) · h / sqrt(h² + 1), with h the smallest
    entry of the unit vector along the least forces f >= 1 that make no torque; the best of all
    muscles, and of all but one. Kurtz, Hayward, "Dexterity measures with unilateral actuation
    constraints: the n + 1 case", Advanced Robotics 9 (1994), widened as CASPR's
    `UnilateralDexterityMetric` does.
    """
    poses = _poses(L)
    best = _dexterity(poses.L)
    everyone = best > 0
    if poses.m > poses.n + 1:
        for k in range(poses.m):
            some = np.delete(poses.L[everyone], k, axis=1)
            best[everyone] = np.maximum(best[everyone], _dexterity(some))
    return best.reshape(poses.stack)


def _dexterity(L: FloatArray) -> FloatArray:
    """Return the dexterity of all muscles together, shape (P,)."""
    (P, m, n), values = L.shape, np.zeros(len(L))
    if not P or m < n:
        return values
    solver = BoxSolver(m, n)
    condition = condition_number(L)
    for k in np.flatnonzero(full_rank(L)):
        problem = BoxProblem(
            np.ones(m), np.zeros(m), -L[k].T, np.zeros(n), np.ones(m), np.full(m, np.inf)
        )
        answer = solver.solve(problem)
        if answer.status == "solved":
            h = answer.x.min() / np.linalg.norm(answer.x)
            values[k] = np.sqrt(m + 1.0) * condition[k] * h / np.sqrt(h**2 + 1.0)
    return values


def _poses(L: ArrayLike) -> Poses:
    return gather(L, np.zeros(np.shape(L)[-1:]), 0.0, np.inf)
