"""Deviations of numbers whose readings change along a curve: the second derivative's part.

From what was found to the truth, numbers that readings hardly tell may be far off. Others that go
with them move on a curve, of which a covariance knows the tangent only. Along a change c that is
drawn of it they move, to second order, by (Bates & Watts 1988, Nonlinear Regression Analysis, 7.1)

    -1/2 C J'(r(z + c) - 2 r(z) + r(z - c))
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim_dart.core.arrays import FloatArray

from .problem import CalibrationProblem
from .readings import Window

_CURVED = ("point", "offset", "stiffness")
"""What lengths depend on by a curve, and what goes with it."""

_DRAWS = 32
_WINDOWS = 64


def bends(
    problem: CalibrationProblem,
    z: FloatArray,
    cut: Sequence[Window],
    starts: Sequence[FloatArray],
    covariance: FloatArray,
) -> FloatArray:
    """RMS of what numbers move by besides their tangent, over their priors' sd, shape (P,).

    Args:
        problem: The calibration.
        z: What was found, shape (P,).
        cut: The windows that it was found from.
        starts: Where they begin, so that they fit best.
        covariance: Of z, shape (P, P).

    Returns:
        Infinity where a window diverges within a deviation.
    """
    P = len(z)
    drawn = [k for k, one in enumerate(problem.parameters) if one.kind in _CURVED]
    if not any(problem.parameters[k].kind == "point" for k in drawn):
        return np.zeros(P)
    every = -(-len(cut) // _WINDOWS)
    root = covariance_root(covariance[np.ix_(drawn, drawn)])
    changes = np.zeros((_DRAWS, P))
    changes[:, drawn] = np.random.default_rng(0).normal(size=(_DRAWS, len(drawn))) @ root.T
    bent = problem.bent(z, cut[::every], starts[::every], changes)
    if bent is None:
        return np.full(P, np.inf)
    H, curved = bent
    moved = -0.5 * every * np.linalg.solve(every * H + problem.prior(z)[2], curved.T).T
    return np.asarray(np.sqrt(np.mean(moved**2, axis=0)))


def covariance_root(C: FloatArray) -> FloatArray:
    """R with R R' = C, shape (k, k), where rounding has left some direction no variance, too."""
    try:
        return np.linalg.cholesky(C).astype(np.float64)
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(C)
        root: FloatArray = vectors * np.sqrt(np.maximum(values, 0.0))
        return root
