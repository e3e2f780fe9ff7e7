"""Closed-form force distributions, vectorised over poses. They may fail for a feasible torque.

With the mean f_m of the force limits, A = -L' and its pseudo-inverse A⁺:

    closed form (`cfm`)            f = f_m + A⁺ (tau - A f_m)
    improved (`icfm`)              fix the force that violates its limit most, and repeat
    puncture (`pm`)                move from the smallest f = A⁺ tau towards the closed form, until
                                   every force is within its limits
    improved puncture (`ipm`)      move towards the improved closed form, with the same fixed forces

Pott et al., "Closed-form force distribution for parallel wire robots", Computational Kinematics
(2009); Pott, "An improved force distribution algorithm for over-constrained cable-driven parallel
robots", Computational Kinematics (2014); Müller, Reichert, Bruckmann, "Analysis of a real-time
capable cable force computation method", Cable-Driven Parallel Robots (2015). CASPR's `aicfm` and
`aipm` compute the same forces in another way. Its `wicfm` and `wipm` approximate the optimum of
`least_squares` with the target f_m.
"""

from __future__ import annotations

import numpy as np

from controllers.arrays import BoolArray, FloatArray

from .poses import Poses, distribution

_RANK_TOLERANCE = 1e-10  # singular values are zero below this fraction of the largest
_LIMIT_TOLERANCE = 1e-9  # allowed violation of a limit, relative to 1 N or the limit


@distribution(finite_bounds=True)
def closed_form(poses: Poses) -> FloatArray:
    """Return the forces nearest to the mean of the force limits, without enforcing the limits."""
    middle = poses.middle
    free = np.ones_like(middle, dtype=bool)
    return _nearest(poses, middle, free, middle)


@distribution(finite_bounds=True)
def improved_closed_form(poses: Poses) -> FloatArray:
    """Return the closed form, after fixing violating forces at their limits one by one."""
    return _improved(poses, poses.middle)[0]


@distribution(finite_bounds=True)
def puncture(poses: Poses) -> FloatArray:
    """Return the smallest feasible forces between the minimum norm and the closed form."""
    middle = poses.middle
    free = np.ones_like(middle, dtype=bool)
    safe = _nearest(poses, middle, free, middle)
    smallest = _nearest(poses, np.zeros_like(middle), free, middle)
    return _first_feasible(poses, smallest, safe)


@distribution(finite_bounds=True)
def improved_puncture(poses: Poses) -> FloatArray:
    """Return the smallest feasible forces between the minimum norm and the improved form."""
    middle = poses.middle
    all_free, zero = np.ones_like(middle, dtype=bool), np.zeros_like(middle)
    unbounded = _nearest(poses, zero, all_free, middle)
    safe, free, fixed = _improved(poses, middle)
    bounded = _first_feasible(poses, _nearest(poses, zero, free, fixed), safe)
    fits = _violation(poses, unbounded).max(axis=1, keepdims=True) <= 0
    return np.where(fits, unbounded, bounded)


def _nearest(poses: Poses, centre: FloatArray, free: BoolArray, fixed: FloatArray) -> FloatArray:
    """Return the forces nearest to the centre that produce the torque, shape (P, m).

    Forces that are not free keep their fixed values.
    """
    start = np.where(free, centre, fixed)
    missing = poses.tau - np.einsum("pnm,pm->pn", poses.A, start)
    inverse = np.linalg.pinv(np.where(free[:, None, :], poses.A, 0.0), rcond=_RANK_TOLERANCE)
    nearest: FloatArray = start + np.einsum("pmn,pn->pm", inverse, missing)
    return nearest


def _violation(poses: Poses, forces: FloatArray) -> FloatArray:
    """Return violations of the force limits beyond rounding, shape (P, m), in [N]."""
    beyond = np.maximum(poses.f_min - forces, forces - poses.f_max)
    return beyond - _LIMIT_TOLERANCE * np.maximum(1.0, poses.f_max)


def _improved(poses: Poses, middle: FloatArray) -> tuple[FloatArray, BoolArray, FloatArray]:
    """Return the improved closed form, a mask of free forces, and values of fixed forces."""
    free, fixed = np.ones_like(middle, dtype=bool), middle.copy()
    forces = _nearest(poses, middle, free, fixed)
    for _ in range(poses.m - poses.n):
        beyond = np.where(free, _violation(poses, forces), -np.inf)
        worst = beyond.argmax(axis=1)
        rows = np.flatnonzero(beyond.max(axis=1) > 0)
        if not len(rows):
            break
        k = worst[rows]
        too_low = forces[rows, k] < poses.f_min[rows, k]
        free[rows, k] = False
        fixed[rows, k] = np.where(too_low, poses.f_min[rows, k], poses.f_max[rows, k])
        chosen = np.zeros(len(forces), dtype=bool)
        chosen[rows] = True
        forces[rows] = _nearest(poses.only(chosen), middle[rows], free[rows], fixed[rows])
    return forces, free, fixed


def _first_feasible(poses: Poses, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the first feasible point between start and end, or the end, shape (P, m)."""
    direction = end - start
    bound = np.clip(start, poses.f_min, poses.f_max)
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.where(_violation(poses, start) <= 0.0, 0.0, (bound - start) / direction)
    needed = np.where(np.isfinite(needed), needed, 1.0)
    s = np.clip(needed.max(axis=1, keepdims=True), 0.0, 1.0)
    return np.asarray(start + s * direction)
