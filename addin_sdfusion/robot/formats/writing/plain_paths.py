"""Simplification of muscle paths for formats that do not support all path features."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace

from ...model.muscle import Muscle, ViaPoint
from ...model.robot import MARKERS, Robot


def with_plain_paths(robot: Robot, supported: Container[str] = ()) -> Robot:
    """Return the robot with only the path features of a format, and without repeated points.

    Two via points at the same position may differ in their conditions, their motion, or their
    branch. In a format without these, the second point is redundant and is removed.

    Args:
        supported: The features among `conditions`, `moves` and `branches` of the format.
    """
    sets = (
        replace(group, muscles=tuple(_plain_muscle(muscle, supported) for muscle in group.muscles))
        for group in robot.cable_sets
    )
    return replace(robot, cable_sets=tuple(sets))


def _plain_muscle(muscle: Muscle, supported: Container[str]) -> Muscle:
    points = [_point(point, supported) for point in muscle.via_points]
    branches = muscle.branches if "branches" in supported else ()
    begins = {branch.point for branch in branches}
    places: list[int] = []  # index of each via point in the path
    path: list[ViaPoint] = []
    for k, point in enumerate(points):
        if not path or k in begins or replace(point, friction=path[-1].friction) != path[-1]:
            path.append(point)
        places.append(len(path) - 1)
    if len(path) == len(points):
        return replace(muscle, via_points=tuple(points), branches=branches)
    wraps = (
        replace(
            wrap,
            segment=places[wrap.segment],
            last_segment=wrap.last_segment and places[wrap.last_segment],
        )
        for wrap in muscle.wraps
    )
    branches = tuple(replace(branch, point=places[branch.point]) for branch in branches)
    return replace(muscle, via_points=tuple(path), wraps=tuple(wraps), branches=branches)


def _point(point: ViaPoint, supported: Container[str]) -> ViaPoint:
    when = point.when if "conditions" in supported else None
    return replace(point, when=when, moves=point.moves if "moves" in supported else ())


def with_markers(robot: Robot) -> Robot:
    """Return the robot with its markers as active task set if it has no other task set."""
    has_markers = any(group.name == MARKERS for group in robot.task_sets)
    return replace(robot, task_set=MARKERS) if has_markers and not robot.task_set else robot
