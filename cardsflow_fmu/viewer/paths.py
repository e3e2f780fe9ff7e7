"""The ways of all muscles through the world, as they are simulated.

This is the one place where a viewer learns the geometry of a path.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot

from .poses import FloatArray, Poses, moved_point


@dataclass(frozen=True, eq=False)
class MusclePath:
    """The way of a muscle at K frames.

    Attributes:
        points: Corners of the way, shape (K, p, 3), in [m]; equal ones may stand one after another.
        via: Which of the corners are the via points, shape (K, v).
    """

    points: FloatArray
    via: NDArray[np.int64]


def muscle_paths(robot: Robot, poses: Poses) -> list[MusclePath]:
    """The ways of the muscles, in their order: straight from via point to via point.

    Args:
        robot: A valid robot.
        poses: Of its links.
    """
    paths = []
    for muscle in robot.muscles:
        corners = [moved_point(poses[point.link], point.position) for point in muscle.via_points]
        points = np.stack(corners, axis=1)
        via = np.broadcast_to(np.arange(len(corners)), points.shape[:2])
        paths.append(MusclePath(points, via))
    return paths


def pulls(path: MusclePath) -> FloatArray:
    """What a muscle of tension 1 does at each of its via points: the force, shape (K, v, 3).

    Args:
        path: The way of the muscle.
    """
    step = np.diff(path.points, axis=1)
    length = np.linalg.norm(step, axis=2, keepdims=True)
    ahead = np.divide(step, length, out=np.zeros_like(step), where=length > 0.0)
    forces = np.zeros_like(path.points)
    forces[:, :-1] += ahead
    forces[:, 1:] -= ahead
    frames = np.arange(len(path.points))[:, np.newaxis]
    at_via_points: FloatArray = forces[frames, path.via]
    return at_via_points
