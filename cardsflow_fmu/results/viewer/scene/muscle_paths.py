"""Muscle paths in the world frame, as in the simulation."""

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
    """Path of a muscle at K frames.

    Attributes:
        points: Corners of the path, shape (K, p, 3), in [m]; consecutive ones may be equal.
        via: Indices of the via points among the corners, shape (K, v).
    """

    points: FloatArray
    via: NDArray[np.int64]


def muscle_paths(robot: Robot, q: FloatArray, poses: Poses) -> list[MusclePath]:
    """Return the paths of the muscles, in the order of the robot.

    Args:
        q: Joint positions, shape (K, n), in [rad] or [m].
    """
    paths = []
    for muscle in robot.muscles:
        corners = [moved_point(poses[point.link], point.position) for point in muscle.via_points]
        points = np.stack(corners, axis=1) if corners else np.zeros((len(q), 0, 3))
        via = np.broadcast_to(np.arange(len(corners)), points.shape[:2])
        paths.append(MusclePath(points, via))
    bent = [k for k, m in enumerate(robot.muscles) if m.via_points and not m.is_straight]
    if bent:
        _replace_bent_paths(robot, q, paths, bent)
    return paths


def _replace_bent_paths(
    robot: Robot, q: FloatArray, paths: list[MusclePath], bent: list[int]
) -> None:
    """Replace straight paths by the paths over wrap surfaces and pulleys.

    Args:
        q: Joint positions, shape (K, n), in [rad] or [m].
        paths: Straight paths; changed in place.
        bent: Indices of the muscles with wrap surfaces or pulleys.
    """
    core = MusclePaths(robot)
    lines = [core.path_points(row) for row in q]
    for k in bent:
        bends = [frame[k] for frame in lines]
        via = np.array([_indices_of(*pair) for pair in zip(paths[k].points, bends, strict=True)])
        longest = max(map(len, bends))
        padded = [np.pad(path, ((0, longest - len(path)), (0, 0)), "edge") for path in bends]
        paths[k] = MusclePath(np.stack(padded), via)


def _indices_of(points: FloatArray, path: FloatArray) -> list[int]:
    """Return the indices of the via points in a path, in order."""
    indices, begin = [], 0
    for point in points:
        begin += int(np.argmin(np.linalg.norm(path[begin:] - point, axis=1)))
        indices.append(begin)
        begin += begin < len(path) - 1
    return indices


def stump(points: FloatArray, share: float = 0.4) -> FloatArray:
    """Return the points of a broken cable, which ends after a share of its path, shape (p, 3)."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    at = np.minimum(along, share * along[-1])
    return np.stack([np.interp(at, along, axis) for axis in points.T], axis=1)


def unit_forces(path: MusclePath) -> FloatArray:
    """Return the force at each via point of a muscle with tension 1 N, shape (K, v, 3), in [N]."""
    step = np.diff(path.points, axis=1)
    length = np.linalg.norm(step, axis=2, keepdims=True)
    ahead = np.divide(step, length, out=np.zeros_like(step), where=length > 0.0)
    forces = np.zeros_like(path.points)
    forces[:, :-1] += ahead
    forces[:, 1:] -= ahead
    frames = np.arange(len(path.points))[:, np.newaxis]
    at_via_points: FloatArray = forces[frames, path.via]
    return at_via_points
