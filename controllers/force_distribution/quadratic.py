"""Least squares: min (f - f_p)'H (f - f_p) s.t. -L'f = tau, f_min <= f <= f_max.

The method corresponds to `IDSolverQuadProg` of CASPR. The solution is unique and continuous along a
motion.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray
from controllers.qp.dual_newton import SOLVED, DualNewton
from controllers.validation import named_vector

from .poses import Poses, distribution


@distribution()
def least_squares(poses: Poses, *, weights: ArrayLike = 1.0, target: ArrayLike = 0.0) -> FloatArray:
    """Minimise the weighted squared distance of the forces to a target.

    Poses are solved in order. Each solution starts from the multipliers of the previous pose, so
    that the poses of a motion require about one Newton step each.

    Args:
        poses: Poses of a robot with any number of muscles.
        weights: Diagonal of H, a number or shape (m,), in [1/N²].
        target: f_p, a number, shape (m,) or (..., m), in [N]. Use 0 for `IDObjectiveMinQuad` of
            CASPR, and the mean of the limits for its `IDObjectiveQuadOptimallySafe`.

    Raises:
        InputError: A size is wrong, or a number is out of range.
    """
    names = [f"muscle {k + 1}" for k in range(poses.m)]
    H = named_vector("weights", weights, names, above=0.0)
    return solve_poses(poses, H, broadcast_target(poses, target))


def broadcast_target(poses: Poses, target: ArrayLike) -> FloatArray:
    """Return a target for each pose, shape (P, m), in [N].

    Args:
        target: A number, shape (m,) or (..., m), in [N].

    Raises:
        InputError: The target has another shape, or is not finite.
    """
    try:
        goal = np.broadcast_to(np.asarray(target, float), (*poses.stack, poses.m))
    except (TypeError, ValueError):
        raise InputError(f"target must be a number or {poses.m} numbers, not {target!r}") from None
    if not np.isfinite(goal).all():
        raise InputError("target must be finite")
    return goal.reshape(-1, poses.m)


def solve_poses(poses: Poses, H: FloatArray, target: FloatArray) -> FloatArray:
    """Solve the QP of each pose; shape (P, m), in [N], NaN if not solved.

    Args:
        H: Weights, shape (m,).
        target: f_p, shape (P, m), in [N].
    """
    forces = np.full((len(poses.L), poses.m), np.nan)
    if not len(forces):
        return forces
    solver, H = DualNewton(poses.m, poses.n), H / H.mean()
    solver.H_diagonal[:], solver.softness[:] = H, 0.0
    for k in range(len(forces)):
        solver.g[:], solver.A[...], solver.b[:] = -H * target[k], poses.A[k], poses.tau[k]
        solver.lb[:], solver.ub[:] = poses.f_min[k], poses.f_max[k]
        if solver.solve() == SOLVED:
            forces[k] = solver.x
    return forces
