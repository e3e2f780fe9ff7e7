"""Standard deviations of parameters due to the nonlinearity of measurements.

A linearised covariance ignores the curvature of the model. If some parameters are hardly
identifiable, their large deviations cause additional deviations of other parameters. To second
order, a change c drawn from the covariance causes the deviation (Bates & Watts 1988, Nonlinear
Regression Analysis, 7.1)

    -1/2 C J'(r(z + c) - 2 r(z) + r(z - c))
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim_dart.core.arrays import FloatArray

from .problem import CalibrationProblem
from .recordings import Window

_CURVED = ("point", "offset", "stiffness")
"""Kinds of parameters on which lengths depend nonlinearly, or that are correlated with these."""

_DRAWS = 32
_WINDOWS = 64


def curvature_deviations(
    problem: CalibrationProblem,
    z: FloatArray,
    windows: Sequence[Window],
    starts: Sequence[FloatArray],
    covariance: FloatArray,
) -> FloatArray:
    """Compute the RMS deviations due to nonlinearity, over the prior sd, shape (P,).

    Args:
        z: The solution, shape (P,).
        starts: Fitted start states of the windows.
        covariance: Covariance of z, shape (P, P).

    Returns:
        The deviations. They are infinite if a window diverges within a standard deviation.
    """
    P = len(z)
    drawn = [k for k, one in enumerate(problem.parameters) if one.kind in _CURVED]
    if not any(problem.parameters[k].kind == "point" for k in drawn):
        return np.zeros(P)
    every = -(-len(windows) // _WINDOWS)
    root = covariance_root(covariance[np.ix_(drawn, drawn)])
    changes = np.zeros((_DRAWS, P))
    changes[:, drawn] = np.random.default_rng(0).normal(size=(_DRAWS, len(drawn))) @ root.T
    second_order_terms = problem.second_order_terms(z, windows[::every], starts[::every], changes)
    if second_order_terms is None:
        return np.full(P, np.inf)
    H, curved = second_order_terms
    moved = -0.5 * every * np.linalg.solve(every * H + problem.prior(z)[2], curved.T).T
    return np.asarray(np.sqrt(np.mean(moved**2, axis=0)))


def covariance_root(C: FloatArray) -> FloatArray:
    """Return R with R R' = C, shape (k, k), for positive semidefinite C with rounding errors."""
    try:
        return np.linalg.cholesky(C).astype(np.float64)
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(C)
        root: FloatArray = vectors * np.sqrt(np.maximum(values, 0.0))
        return root
