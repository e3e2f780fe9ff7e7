"""Interior-point method for sparse quadratic programs, by Mehrotra's predictor and corrector."""

from __future__ import annotations

import numpy as np
from scipy.sparse import bmat, csc_matrix, diags, identity, vstack
from scipy.sparse.linalg import splu

from controllers.arrays import FloatArray

_TOLERANCE = 1e-9
_MAX_ITERATIONS = 100
_REGULARISATION = 1e-11
_MAX_STEP = 0.995


def solve_interior(
    P: csc_matrix,
    g: FloatArray,
    A: csc_matrix,
    b: FloatArray,
    C: csc_matrix,
    low: FloatArray,
    high: FloatArray,
    lb: FloatArray,
    ub: FloatArray,
) -> tuple[FloatArray, FloatArray, bool]:
    """Return the solution, the multipliers of A, and whether it is optimal.

    The arguments are those of `QuadraticProgram`. All inequalities become F d <= h with slacks s.
    """
    n = len(g)
    rows = vstack([identity(n, format="csr"), C], format="csr")
    least, most = np.concatenate([lb, low]), np.concatenate([ub, high])
    has_low, has_high = np.isfinite(least), np.isfinite(most)
    F = vstack([rows[has_high], -rows[has_low]], format="csc")
    h = np.concatenate([most[has_high], -least[has_low]])
    count = len(h)
    d, y = np.zeros(n), np.zeros(len(b))
    s = np.maximum(h - F @ d, 1.0)
    z = np.ones(count)
    scale = 1.0 + max(np.abs(g).max(initial=0.0), np.abs(b).max(initial=0.0))
    dual = -_REGULARISATION * identity(len(b), format="csc")
    for _ in range(_MAX_ITERATIONS):
        r_d = P @ d + g + A.T @ y + F.T @ z
        r_p, r_s = A @ d - b, F @ d + s - h
        gap = s @ z / max(count, 1)
        worst = max(np.abs(r).max(initial=0.0) for r in (r_d, r_p, r_s))
        if worst < _TOLERANCE * scale and gap < _TOLERANCE * scale:
            return d, y, True
        if not np.isfinite(worst) or np.abs(z).max(initial=0.0) > 1e14:
            break
        H = P + F.T @ diags(z / s) @ F + _REGULARISATION * identity(n)
        try:
            factor = splu(bmat([[H, A.T], [A, dual]], format="csc"))
        except RuntimeError:  # exactly singular
            break

        def step(r_c: FloatArray) -> tuple[FloatArray, ...]:
            """Solve the linearised conditions with s z = s z - r_c."""
            rhs = -r_d - F.T @ ((z * r_s - r_c) / s)  # noqa: B023
            both = factor.solve(np.concatenate([rhs, -r_p]))  # noqa: B023
            dd, dy = both[:n], both[n:]
            ds = -r_s - F @ dd  # noqa: B023
            return dd, dy, ds, -(r_c + z * ds) / s  # noqa: B023

        _, _, ds, dz = step(s * z)
        alpha = min(_largest(s, ds), _largest(z, dz))
        after = (s + alpha * ds) @ (z + alpha * dz) / max(count, 1)
        centre = (after / gap) ** 3 * gap if count else 0.0
        dd, dy, ds, dz = step(s * z + ds * dz - centre)
        alpha = _MAX_STEP * min(_largest(s, ds), _largest(z, dz))
        d, y, s, z = d + alpha * dd, y + alpha * dy, s + alpha * ds, z + alpha * dz
    return d, y, False


def _largest(values: FloatArray, change: FloatArray) -> float:
    """Return the largest step up to 1 that keeps the values from 0."""
    falls = change < 0.0
    return min(1.0, float((-values[falls] / change[falls]).min(initial=1.0)))
