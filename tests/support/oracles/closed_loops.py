"""Poses of robots with closed loops: all dependent coordinates follow by Newton's method."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot

from .loop_model import link_poses, loop_jacobian, residuals

Array = NDArray[np.float64]


def initial(robot: Robot) -> Array:
    """Return the initial coordinates."""
    return np.array([c.initial for c in robot.coordinates])


def closed(robot: Robot, name: str, by: float) -> Array:
    """Return the coordinates after one of them moved from its initial value."""
    names = [c.name for c in robot.coordinates]
    driven, q = names.index(name), initial(robot)
    free = [k for k in range(len(q)) if k != driven]
    for step in np.linspace(0.0, by, 5)[1:]:
        q[driven] = robot.coordinates[driven].initial + step
        for _ in range(8):
            J = loop_jacobian(robot, q)[:, free]
            q[free] -= np.linalg.lstsq(J, residuals(robot, q).real, rcond=1e-8)[0]
    assert np.abs(residuals(robot, q)).max() < 1e-13
    return q


def closed_poses(robot: Robot, name: str, by: float) -> dict[str, Array]:
    """Return the link poses in the world frame after a coordinate moved."""
    q = closed(robot, name, by)
    return {link: T.real for link, T in link_poses(robot, q.astype(complex)).items()}
