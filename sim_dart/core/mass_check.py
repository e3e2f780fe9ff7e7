"""Check that a robot's mass matrix can be inverted, whatever the engine."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError, Robot

from .arrays import FloatArray

_SINGULAR = 1e-13


def require_inertia(robot: Robot, M: FloatArray) -> None:
    """Refuse a robot that some motion does not move any mass of.

    Args:
        robot: The robot, for the message.
        M: Its mass matrix at any position, shape (n, n).

    Raises:
        InputError: The matrix is singular, or a number of it is too large to compute with.
    """
    if not np.isfinite(M).all():
        raise InputError(
            f"robot {robot.name!r}: its mass matrix is not finite; "
            "its masses or lengths are too large"
        )
    scale = np.sqrt(np.abs(np.diag(M)))
    scaled = M / np.outer(scale, scale) if scale.all() else np.zeros_like(M)
    if M.size and np.linalg.eigvalsh(scaled)[0] <= _SINGULAR:
        raise InputError(
            f"robot {robot.name!r}: its mass matrix is singular, as some motion of its joints "
            "moves no mass; give the links between them masses and inertias"
        )
