"""Every number is finite, except limits that may be open."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from ..finding import Finding, Subject, member
from ..joint import Coordinate, Joint
from ..model import Link, Robot
from ..muscle import Muscle
from .report import error, finite


def numbers(robot: Robot) -> Iterator[Finding]:
    """No number is NaN, and none is infinite where that has no meaning."""
    yield from _report(Subject("robot", robot.name), "gravity", robot.gravity)
    for link in robot.links:
        yield from _report(Subject("link", link.name), "mass or inertia", link_numbers(link))
        yield from _report(Subject("link", link.name), "end", link.end or ())
    for joint in robot.joints:
        yield from _report(Subject("joint", joint.name), "pose or axis", joint_numbers(joint))
        for c in joint.coordinates:
            subject = Subject("coordinate", c.name)
            yield from _report(subject, "initial value or damping", (c.initial, c.damping))
            yield from _limits(subject, c)
    for cable_set in robot.cable_sets:
        for muscle in cable_set.muscles:
            subject = member("muscle", muscle.name, cable_set.name, robot.cable_set)
            yield from _report(subject, "via point or force limit", muscle_numbers(muscle))
    for task_set in robot.task_sets:
        for frame in task_set.frames:
            subject = member("task_frame", frame.name, task_set.name, robot.task_set)
            yield from _report(subject, "position", frame.position)


def link_numbers(link: Link) -> tuple[float, ...]:
    """What describes a link's mass."""
    i = link.inertia
    return (i.mass, *i.com, i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz)


def joint_numbers(joint: Joint) -> tuple[float, ...]:
    """What places a joint."""
    poses = (joint.T_parent_joint, joint.T_child_joint)
    axes = [number for motion in joint.motions for number in motion.axis]
    return (*axes, *(number for pose in poses for number in (*pose.position, *pose.rpy)))


def muscle_numbers(muscle: Muscle) -> tuple[float, ...]:
    """What describes a muscle, without an open upper force limit."""
    points = [number for point in muscle.via_points for number in point.position]
    upper = () if muscle.f_max == math.inf else (muscle.f_max,)
    return (*points, muscle.f_min, *upper)


def _limits(subject: Subject, c: Coordinate) -> Iterator[Finding]:
    lower = () if c.lower == -math.inf else (c.lower,)
    upper = () if c.upper == math.inf else (c.upper,)
    yield from _report(subject, "limit", lower + upper)


def _report(subject: Subject, what: str, values: Iterable[float]) -> Iterator[Finding]:
    if not finite(values):
        yield error(subject, "not-finite", f"{what} is not a finite number")
