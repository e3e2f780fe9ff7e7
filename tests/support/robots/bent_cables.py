"""Robots whose cables bend at via points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import WORLD, CableModel, Robot, ViaPoint
from sim_dart.muscles.paths import MusclePaths


def with_bent_cables(robot: Robot, friction: float, q: ArrayLike) -> Robot:
    """Return a robot whose cables start 0.1 m aside and bend by 90 degrees at the first point.

    Args:
        robot: Robot whose muscles begin in the world.
        friction: Friction coefficient of all bends.
        q: Pose with this angle; the angle changes with the position of the next point.
    """
    muscles = []
    for muscle, line in zip(robot.muscles, MusclePaths(robot).path_points(q), strict=True):
        aside = np.cross(line[1] - line[0], (0.3, 0.5, 0.8))
        x, y, z = line[0] + 0.1 * aside / np.linalg.norm(aside)
        points = (ViaPoint(WORLD, (float(x), float(y), float(z))), *muscle.via_points)
        muscles.append(replace(muscle, friction=friction, via_points=points))
    return robot.with_muscles(muscles)


def elastic_bent_cables(robot: Robot) -> Robot:
    """Return a robot with elastic cables and friction in the bends."""
    values = (("stiffness", 2e3), ("damping", 1.0), ("longest_rest_length", 5.0))
    model = CableModel("elastic_cable", values)
    return robot.with_muscles([replace(m, friction=0.3, model=model) for m in robot.muscles])
