"""Closed forms: a few projections a pose, for all poses at once; they may miss a solution.

With the middle f_m between the bounds, A = -L' and its pseudo-inverse A⁺:

    closed form (`cfm`)            f = f_m + A⁺ (tau - A f_m)
    improved (`icfm`)              the worst force beyond a bound is fixed at it, and the rest again
    puncture (`pm`)                from the smallest f = A⁺ tau towards the closed form, until
                                   every force is within its bounds
    improved puncture (`ipm`)      the same towards the improved form, with the same forces fixed

Pott et al., "Closed-form force distribution for parallel wire robots", Computational Kinematics
(2009); Pott, "An improved force distribution algorithm for over-constrained cable-driven parallel
robots", Computational Kinematics (2014); Müller, Reichert, Bruckmann, "Analysis of a real-time
capable cable force computation method", Cable-Driven Parallel Robots (2015). CASPR's `aicfm` and
`aipm` are other arithmetic for the same forces; its `wicfm` and `wipm` look for the optimum that
`least_squares` with the middle as its target gives.
"""

from __future__ import annotations

import numpy as np

from controllers.arrays import BoolArray, FloatArray

from .poses import Poses, distribution

_RANK = 1e-10  # singular values below this part of the largest are zero
_BEYOND = 1e-9  # a force this far beyond a bound violates it, relative to 1 N or the bound


@distribution(finite_bounds=True)
def closed_form(poses: Poses) -> FloatArray:
    """Return the forces nearest to the middle between the bounds, whatever the bounds."""
    middle = poses.middle
    free = np.ones_like(middle, dtype=bool)
    return _nearest(poses, middle, free, middle)


@distribution(finite_bounds=True)
def improved_closed_form(poses: Poses) -> FloatArray:
    """Return the closed form, with forces beyond their bounds fixed there one after another."""
    return _improved(poses, poses.middle)[0]


@distribution(finite_bounds=True)
def puncture(poses: Poses) -> FloatArray:
    """Return the smallest forces on the way from the least norm to the closed form."""
    middle = poses.middle
    free = np.ones_like(middle, dtype=bool)
    safe = _nearest(poses, middle, free, middle)
    smallest = _nearest(poses, np.zeros_like(middle), free, middle)
    return _towards(poses, smallest, safe)


@distribution(finite_bounds=True)
def improved_puncture(poses: Poses) -> FloatArray:
    """Return the smallest forces on the way from the least norm to the improved closed form."""
    middle = poses.middle
    all_free, zero = np.ones_like(middle, dtype=bool), np.zeros_like(middle)
    unbounded = _nearest(poses, zero, all_free, middle)
    safe, free, fixed = _improved(poses, middle)
    way = _towards(poses, _nearest(poses, zero, free, fixed), safe)
    fits = _violation(poses, unbounded).max(axis=1, keepdims=True) <= 0
    return np.where(fits, unbounded, way)


def _nearest(poses: Poses, centre: FloatArray, free: BoolArray, fixed: FloatArray) -> FloatArray:
    """The forces nearest to the centre that make the torque, some of them fixed; shape (P, m)."""
    start = np.where(free, centre, fixed)
    missing = poses.tau - np.einsum("pnm,pm->pn", poses.A, start)
    inverse = np.linalg.pinv(np.where(free[:, None, :], poses.A, 0.0), rcond=_RANK)
    nearest: FloatArray = start + np.einsum("pmn,pn->pm", inverse, missing)
    return nearest


def _violation(poses: Poses, forces: FloatArray) -> FloatArray:
    """How far forces are beyond their bounds, shape (P, m), in [N]; rounding counts as within."""
    beyond = np.maximum(poses.f_min - forces, forces - poses.f_max)
    return beyond - _BEYOND * np.maximum(1.0, poses.f_max)


def _improved(poses: Poses, middle: FloatArray) -> tuple[FloatArray, BoolArray, FloatArray]:
    """The improved closed form, which forces are free in it, and the values of the fixed ones."""
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


def _towards(poses: Poses, start: FloatArray, end: FloatArray) -> FloatArray:
    """The first point within the bounds on the way from start to end, else the end; (P, m)."""
    way = end - start
    bound = np.clip(start, poses.f_min, poses.f_max)
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.where(_violation(poses, start) <= 0.0, 0.0, (bound - start) / way)
    needed = np.where(np.isfinite(needed), needed, 1.0)
    s = np.clip(needed.max(axis=1, keepdims=True), 0.0, 1.0)
    return np.asarray(start + s * way)
