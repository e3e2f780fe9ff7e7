"""Check that the mass matrix of a robot is not singular."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError, Robot

from .arrays import FloatArray

_SINGULAR = 1e-13
_ROUNDING = 1e-15  # rounding error of a zero, relative to the largest inertia of the same unit


def massless_coordinates(robot: Robot, M: FloatArray) -> list[str]:
    """Return the names of coordinates that make the mass matrix singular.

    These coordinates move no mass, or only mass that other coordinates move in the same way. They
    are found by a Cholesky decomposition with pivoting of M, scaled to ones on its diagonal.

    Args:
        M: Its mass matrix at any position, shape (n, n), finite.
    """
    inertia, units = np.diag(M), np.array([c.unit for c in robot.coordinates])
    largest = {unit: inertia[units == unit].max() for unit in set(units)}
    zero = inertia <= [_ROUNDING * largest[unit] for unit in units]
    remaining = [k for k in range(len(M)) if not zero[k]]
    root = np.sqrt(np.where(zero, 1.0, inertia))
    A = M / np.outer(root, root)
    while remaining:
        best = max(remaining, key=lambda k: float(A[k, k]))
        if A[best, best] <= _SINGULAR:
            break
        remaining.remove(best)
        A = A - np.outer(A[:, best], A[best]) / A[best, best]
    return [c.name for k, c in enumerate(robot.coordinates) if zero[k] or k in remaining]


def require_inertia(robot: Robot, M: FloatArray) -> None:
    """Reject a robot that has a motion without any moving mass.

    Raises:
        InputError: The matrix is singular or not finite.
    """
    if not np.isfinite(M).all():
        raise InputError(
            f"robot {robot.name!r}: its mass matrix is not finite; "
            "its masses or lengths are too large"
        )
    if massless := massless_coordinates(robot, M):
        raise InputError(
            f"robot {robot.name!r}: its mass matrix is singular, because a motion of these "
            f"coordinates moves no mass: {', '.join(massless)}; set masses and inertias of their "
            f"links, or lock a coordinate: [robot.coordinates.{massless[0]}] locked = true"
        )
