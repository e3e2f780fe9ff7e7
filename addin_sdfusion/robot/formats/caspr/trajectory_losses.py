"""Findings on trajectories that CASPR cannot hold or that do not match the robot."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from ...checks.names import named
from ...finding import Finding, Subject
from ...finding_builders import error, warning
from ...model.robot import Robot
from ...model.trajectory import Trajectory
from .write_trajectories import TIME_TOLERANCE

XML_ID = re.compile(r"[^\W\d][\w.-]*")
"""Pattern of names without spaces that begin with a letter or an underscore."""
NOT_AN_ID = "is not an XML ID; begin with a letter, then use letters, digits, '_', '.', '-'"


def trajectory_losses(robot: Robot, trajectories: Sequence[Trajectory]) -> Iterator[Finding]:
    """Report trajectories that CASPR cannot hold or that do not match the robot."""
    names = [trajectory.name for trajectory in trajectories]
    yield from (
        warning(Subject("trajectory", name), "caspr-id", NOT_AN_ID)
        for name in names
        if not XML_ID.fullmatch(name)
    )
    yield from named([Subject("trajectory", name) for name in names])
    for trajectory in trajectories:
        yield from _trajectory(robot, trajectory)


def _trajectory(robot: Robot, trajectory: Trajectory) -> Iterator[Finding]:
    subject = Subject("trajectory", trajectory.name)
    size = len(trajectory.points[0].q)
    if trajectory.space == "joint" and size != len(robot.coordinates):
        problem = f"has {size} values per point; the robot has {len(robot.coordinates)} coordinates"
        yield error(subject, "caspr-trajectory-size", problem)
    if trajectory.space == "operational":
        sizes = {sum(len(f.axes) for f in group.frames) for group in robot.task_sets}
        if size not in sizes:
            problem = f"has {size} values per point; no operational space has {size} axes"
            yield warning(subject, "caspr-trajectory-size", problem)
        if trajectory.spline not in ("linear", "quintic"):
            problem = f"CASPR has no {trajectory.spline} trajectories in operational space"
            yield warning(subject, "caspr-operational-spline", problem)
    if trajectory.spline == "samples" and not _on_time(trajectory):
        problem = f"its samples are not spaced by {trajectory.time_step!r} s, as CASPR requires"
        yield error(subject, "caspr-sample-times", problem)


def _on_time(trajectory: Trajectory) -> bool:
    return all(
        abs(point.time - k * trajectory.time_step) <= TIME_TOLERANCE
        for k, point in enumerate(trajectory.points)
    )
