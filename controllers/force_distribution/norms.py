"""Minimum p-norm of forces: min |H^1/2 (f - f_p)|_p s.t. -L'f = tau, f_min <= f <= f_max.

The file csrc/laws/norm.c implements the solution. For integer p above 2, Newton's method minimises
the p-th power of the norm. For p = 1 and infinity the problem is a linear program, and the solution
nearest to f_p is used.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from controllers.arrays import FloatArray
from controllers.qp import law_in_c
from controllers.validation import named_vector, require_norm

from .poses import Poses, distribution
from .quadratic import broadcast_target


@distribution()
def p_norm(
    poses: Poses, *, p: float = 4.0, weights: ArrayLike = 1.0, target: ArrayLike = 0.0
) -> FloatArray:
    """Minimise the p-norm of forces, a compromise between least squares and minimum peak force.

    Args:
        poses: Poses of a robot with any number of muscles.
        p: The norm, an integer from 1 to 8, or infinity.
        weights: Diagonal of H, a number or shape (m,), in [1/N²].
        target: f_p, a number, shape (m,) or (..., m), in [N].

    Raises:
        InputError: A size is wrong, or a number is out of range.
    """
    require_norm(p)
    H = named_vector("weights", weights, [f"muscle {k + 1}" for k in range(poses.m)], above=0.0)
    preferred = broadcast_target(poses, target)
    law = law_in_c.LawInC(poses.n, poses.m)
    law.write(law=law_in_c.GIVEN, norm=p, H_f=H, M=np.eye(poses.n))
    forces = np.full((len(poses.L), poses.m), np.nan)
    for k in range(len(forces)):
        law.write(L=poses.L[k], tau=poses.tau[k], f_p=preferred[k])
        law.write(f_min=poses.f_min[k], f_max=poses.f_max[k])
        if law.solve() == law_in_c.SOLVED:
            forces[k] = law["forces"]
    return forces
