"""The ways of all muscles through the world, as they are simulated.

This is the one place where a viewer learns the geometry of a path.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import MusclePaths

from .link_poses import Poses, moved_point


@dataclass(frozen=True, eq=False)
class MusclePath:
    """The way of a muscle at K frames.

    Attributes:
        points: Corners of the way, shape (K, p, 3), in [m]; equal ones may stand one after another.
        via: Which of the corners are the via points, shape (K, v).
    """

    points: FloatArray
    via: NDArray[np.int64]


def muscle_paths(robot: Robot, q: FloatArray, poses: Poses) -> list[MusclePath]:
    """The ways of the muscles, in their order.

    Args:
        robot: A valid robot.
        q: Joint positions, shape (K, n), in [rad] or [m].
        poses: Of its links at these.
    """
    paths = []
    for muscle in robot.muscles:
        corners = [moved_point(poses[point.link], point.position) for point in muscle.via_points]
        points = np.stack(corners, axis=1)
        via = np.broadcast_to(np.arange(len(corners)), points.shape[:2])
        paths.append(MusclePath(points, via))
    bent = [k for k, m in enumerate(robot.muscles) if m.wraps or m.pulley is not None]
    if bent:
        _follow_surfaces(robot, q, paths, bent)
    return paths


def _follow_surfaces(robot: Robot, q: FloatArray, paths: list[MusclePath], bent: list[int]) -> None:
    """Put the ways of muscles over surfaces and pulleys in the place of straight ones."""
    core = MusclePaths(robot)
    lines = [core.path_points(row) for row in q]
    for k in bent:
        ways = [frame[k] for frame in lines]
        via = np.array([_places_of(*pair) for pair in zip(paths[k].points, ways, strict=True)])
        longest = max(len(way) for way in ways)
        padded = [
            np.concatenate([way, np.repeat(way[-1:], longest - len(way), axis=0)]) for way in ways
        ]
        paths[k] = MusclePath(np.stack(padded), via)


def _places_of(points: FloatArray, way: FloatArray) -> list[int]:
    """Which points of a way are the via points, in order."""
    places, begin = [], 0
    for point in points:
        begin += int(np.argmin(np.linalg.norm(way[begin:] - point, axis=1)))
        places.append(begin)
        begin += begin < len(way) - 1
    return places


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
