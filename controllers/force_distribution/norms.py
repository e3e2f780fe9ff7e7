"""Least p-norms of forces: min |H^1/2 (f - f_p)|_p s.t. -L'f = tau, f_min <= f <= f_max.

p = 1 and infinity are linear programmes. For whole p above 2 the p-th power is made least by
Newton's method: the QP solver takes each step, which goes on to where the power is least on its
way.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from controllers.arrays import FloatArray
from controllers.qp import dual_newton
from controllers.validation import named_vector, require_norm

from .linear import least_largest, least_sum
from .poses import Poses, distribution
from .quadratic import goals, solve_poses

_STEPS = 60
_HALVINGS = 40
_ENOUGH = 1e-15  # a step that is to lower the power by less than this part of it is the last
_CURVED = 1e-12  # least curvature, relative to the largest: of forces that are what is preferred


@distribution()
def p_norm(
    poses: Poses, *, p: float = 4.0, weights: ArrayLike = 1.0, target: ArrayLike = 0.0
) -> FloatArray:
    """The forces of least p-norm: between least squares and the least largest force.

    Args:
        poses: Of any number of muscles.
        p: The norm, a whole number from 1 to 8, or infinity.
        weights: Diagonal of H, a number or shape (m,), in [1/N²].
        target: f_p, a number, shape (m,) or (..., m), in [N].

    Raises:
        InputError: A size or a number is wrong.
    """
    require_norm(p)
    H = named_vector("weights", weights, [f"muscle {k + 1}" for k in range(poses.m)], above=0.0)
    preferred = goals(poses, target)
    forces = solve_poses(poses, H, preferred)
    if p == 2.0:
        return forces
    for k in np.flatnonzero(np.isfinite(forces).all(axis=1)):
        problem = poses.A[k], poses.tau[k], poses.f_min[k], poses.f_max[k]
        found = least_norm(*problem, norm=p, weights=H, target=preferred[k], first=forces[k])
        forces[k] = np.nan if found is None else found
    return forces


def least_norm(
    A: FloatArray,
    b: FloatArray,
    low: FloatArray,
    high: FloatArray,
    *,
    norm: float,
    weights: FloatArray,
    target: FloatArray,
    first: FloatArray,
) -> FloatArray | None:
    """The forces of one pose; None where none are found.

    Args:
        A: -L', shape (n, m).
        b: tau, shape (n,), in [N·m] or [N].
        low: Lower bounds, shape (m,), in [N].
        high: Upper bounds, shape (m,), in [N].
        norm: As of `require_norm`, but 2.
        weights: Diagonal of H, shape (m,), in [1/N²].
        target: f_p, shape (m,), in [N].
        first: The forces of least squares, shape (m,), in [N].
    """
    counts = np.sqrt(weights)
    if norm == 1.0:
        return least_sum(A, b, low, high, counts, target)
    if not math.isfinite(norm):
        return least_largest(A, b, low, high, counts, target)
    return _least_power(A, b, low, high, norm, counts, target, first)


def _least_power(
    A: FloatArray,
    b: FloatArray,
    low: FloatArray,
    high: FloatArray,
    p: float,
    counts: FloatArray,
    target: FloatArray,
    first: FloatArray,
) -> FloatArray | None:
    """The f of min sum |counts (f - target)|^p, by Newton's method from one that is allowed."""
    f, newton = first.copy(), dual_newton.DualNewton(first.size, b.size)
    size = float(np.max(counts * np.abs(f - target), initial=0.0))
    if size == 0.0:
        return f
    newton.A[...], newton.b[:], newton.lb[:], newton.ub[:] = A, b, low, high
    for _ in range(_STEPS):
        z = counts * (f - target) / size
        slope = counts / size * np.abs(z) ** (p - 1) * np.sign(z)
        curve = (p - 1) * (counts / size) ** 2 * np.maximum(np.abs(z) ** (p - 2), _CURVED)
        newton.H_diagonal[:], newton.g[:] = curve, slope - curve * f
        if newton.solve() != dual_newton.SOLVED:
            return None
        way = newton.x - f
        if -(slope @ way) <= _ENOUGH * float(np.sum(np.abs(z) ** p)):
            break
        f += _least_on_way(z, counts * way / size, p) * way
    return f


def _least_on_way(z: FloatArray, dz: FloatArray, p: float) -> float:
    """The t up to 1 where sum |z + t dz|^p is least."""

    def falls(t: float) -> bool:
        at = z + t * dz
        return float(np.sum(np.abs(at) ** (p - 1) * np.sign(at) * dz)) <= 0.0

    if falls(1.0):
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        t = 0.5 * (low + high)
        low, high = (t, high) if falls(t) else (low, t)
    return low
