"""Checks of muscle paths: derivatives by differences, and sums of point forces."""

from __future__ import annotations

import numpy as np

from sim_dart import MusclePaths
from sim_dart.core.arrays import FloatArray
from sim_dart.muscles.path_shapes import PointForces


def check_jacobian(paths: MusclePaths, q: FloatArray, step: float, kink: float = 1e-4) -> int:
    """Assert that L is the derivative of l by central differences, to 1e-7.

    Muscles whose L changes by more than `kink` between the two poses are skipped.

    Returns:
        Number of compared derivatives.
    """
    compared, L = 0, paths.evaluate(q).jacobian.copy()
    for j, e in enumerate(np.eye(len(q)) * step):
        ahead, L_ahead = (values.copy() for values in paths.evaluate(q + e))
        behind, L_behind = (values.copy() for values in paths.evaluate(q - e))
        smooth = (abs(L_ahead - L).max(axis=1) < kink) & (abs(L_behind - L).max(axis=1) < kink)
        slope = (ahead - behind) / (2 * step)
        np.testing.assert_allclose(L[smooth, j], slope[smooth], rtol=0, atol=1e-7)
        compared += int(smooth.sum())
    return compared


def total_forces(pulls: PointForces, m: int) -> tuple[FloatArray, FloatArray]:
    """Return sums of forces, and of torques about the origin, of each muscle, shape (m, 3)."""
    force, torque = np.zeros((m, 3)), np.zeros((m, 3))
    np.add.at(force, pulls.muscles, pulls.forces)
    np.add.at(torque, pulls.muscles, np.cross(pulls.points, pulls.forces))
    return force, torque
