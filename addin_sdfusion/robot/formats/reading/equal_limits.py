"""Joints whose lower and upper limits are equal are read as locked joints."""

from __future__ import annotations

import math

from ...checks.check import check
from ...errors import InputError
from ...finding import Finding, Subject
from ...finding_builders import warning
from ...model.joint import Coordinate
from ...model.robot import Robot
from ...transforms.lock import lock


def lock_equal_limits(robot: Robot) -> tuple[Robot, list[Finding]]:
    """Return the robot with the coordinates locked that cannot move, and a warning for each.

    A robot with errors is returned without changes.
    """
    still = {c.name: c for c in robot.all_coordinates if _cannot_move(c)}
    if not still or any(finding.is_error for finding in check(robot)):
        return robot, []
    try:
        locked = lock(robot, {name: c.lower for name, c in still.items()})
    except InputError:  # the joint cannot express it; its limits remain
        return robot, []
    return locked, [_warning(c) for c in still.values()]


def _cannot_move(c: Coordinate) -> bool:
    return c.is_free and c.lower == c.upper and math.isfinite(c.lower)


def _warning(c: Coordinate) -> Finding:
    motor = "; its motor is ignored" if c.actuated else ""
    problem = f"both limits are {c.lower:g} {c.unit}: read as locked{motor}; widen them if it moves"
    return warning(Subject("coordinate", c.name), "locked-by-limits", problem)
