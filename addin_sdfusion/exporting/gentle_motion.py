"""Small motion near the pose of the design, for the CASPR files of an export."""

from __future__ import annotations

from ..robot.model.joint import Coordinate
from ..robot.model.robot import Robot
from ..robot.model.trajectory import Trajectory, TrajectoryPoint

DURATION = 4.0
"""Duration of the motion to the target and back, in [s]."""
STEP = 0.001
"""Step of the simulation, in [s]."""
REACH = {"rad": 0.1, "m": 0.01}
"""Maximum motion of a coordinate, by its unit."""


def gentle_motion(robot: Robot) -> Trajectory:
    """Return a quintic motion to a pose near the initial pose and back, at rest at every point.

    A coordinate moves in the direction of the more distant limit, by at most half the distance. An
    initial value outside its limits is moved to the nearest limit.
    """
    starts = [min(max(c.initial, c.lower), c.upper) for c in robot.coordinates]
    ends = [_nearby(c, q) for c, q in zip(robot.coordinates, starts, strict=True)]
    rest = (0.0,) * len(starts)
    points = [
        TrajectoryPoint(time, tuple(q), rest, rest)
        for time, q in ((0.0, starts), (0.5 * DURATION, ends), (DURATION, starts))
    ]
    return Trajectory("reference", "quintic", tuple(points), STEP)


def _nearby(c: Coordinate, q: float) -> float:
    up, down = (min(REACH[c.unit], 0.5 * room) for room in (c.upper - q, q - c.lower))
    return q + up if up >= down else q - down
