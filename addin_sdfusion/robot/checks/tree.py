"""The joints make a tree, listed parents first, and each joint is complete."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator

from ..finding import Finding, Subject
from ..model import WORLD, Joint, Robot
from .report import error, finite, unknown, warning

AXIS_TOLERANCE = 1e-6
MOST_NAMES = 20
"""So many links of a loop are named."""
UNITS = {"revolute": ["rad"], "prismatic": ["m"], "fixed": []}


def joint_ends(robot: Robot) -> Iterator[Finding]:
    """Parent and child of every joint exist."""
    links = [link.name for link in robot.links]
    children, parents = set(links), {WORLD, *links}
    for joint in robot.joints:
        subject = Subject("joint", joint.name)
        if joint.parent not in parents:
            problem = f"parent: {unknown('link', joint.parent, [WORLD, *links])}"
            yield error(subject, "unknown-parent", problem)
        if joint.child not in children:
            yield error(subject, "unknown-child", f"child: {unknown('link', joint.child, links)}")


def one_parent_each(robot: Robot) -> Iterator[Finding]:
    """Every link is the child of exactly one joint."""
    counts = Counter(joint.child for joint in robot.joints)
    for name in dict.fromkeys(link.name for link in robot.links):
        subject = Subject("link", name)
        if counts[name] == 0:
            problem = f"no joint connects it to a parent; fix it to {WORLD!r} or to another link"
            yield error(subject, "no-parent", problem)
        if counts[name] > 1:
            joints = ", ".join(repr(joint.name) for joint in robot.joints if joint.child == name)
            yield error(subject, "two-parents", f"is the child of several joints: {joints}")


def parents_first(robot: Robot) -> Iterator[Finding]:
    """No joint comes before the joint that carries its parent."""
    above = {joint.child: joint for joint in reversed(robot.joints)}
    looped = {link for loop in _loops(above) for link in loop}
    placed = {WORLD}
    for joint in robot.joints:
        if joint.parent not in placed and joint.parent in above and joint.child not in looped:
            problem = f"stands before joint {above[joint.parent].name!r} that carries its parent"
            yield error(Subject("joint", joint.name), "joint-order", problem)
        placed.add(joint.child)


def no_loops(robot: Robot) -> Iterator[Finding]:
    """No link carries itself by way of others."""
    above = {joint.child: joint for joint in reversed(robot.joints)}
    for loop in _loops(above):
        links = ", ".join(repr(link) for link in loop[:MOST_NAMES])
        if len(loop) > MOST_NAMES:
            links += ", ..."
        subject = Subject("joint", above[loop[0]].name)
        yield error(subject, "closed-loop", f"closes a loop of links {links}; a robot is a tree")


def axes(robot: Robot) -> Iterator[Finding]:
    """Axes are unit vectors."""
    for joint in robot.joints:
        if joint.type == "fixed" or not finite(joint.axis):
            continue
        norm = math.hypot(*joint.axis)
        subject = Subject("joint", joint.name)
        if norm == 0.0:
            yield error(subject, "zero-axis", "the axis is zero; give it a direction")
        elif not abs(norm - 1.0) <= AXIS_TOLERANCE:
            problem = f"the axis has length {norm:g}; divide it by that"
            yield error(subject, "axis-not-unit", problem)


def coordinates(robot: Robot) -> Iterator[Finding]:
    """Every joint has the coordinates of its type."""
    for joint in robot.joints:
        subject = Subject("joint", joint.name)
        units = [coordinate.unit for coordinate in joint.coordinates]
        if joint.type not in UNITS:
            yield error(subject, "unsupported-joint", f"type {joint.type!r} is not supported")
        elif len(units) != len(UNITS[joint.type]):
            problem = f"{joint.type} needs {len(UNITS[joint.type])} coordinates, has {len(units)}"
            yield error(subject, "wrong-coordinates", problem)
        elif units != UNITS[joint.type]:
            problem = f"a {joint.type} coordinate is in {UNITS[joint.type][0]}, not in {units[0]}"
            yield error(subject, "wrong-unit", problem)


def limits(robot: Robot) -> Iterator[Finding]:
    """Limits are in order and leave room for the initial value; damping is not negative."""
    for c in robot.coordinates:
        subject = Subject("coordinate", c.name)
        if c.damping < 0.0:
            yield error(subject, "negative-damping", f"damping {c.damping!r} is negative")
        if c.lower > c.upper:
            problem = f"lower limit {c.lower!r} is above the upper limit {c.upper!r}"
            yield error(subject, "limits-reversed", problem)
        elif c.lower == c.upper == 0.0:
            problem = "both limits are 0, so it may not move; widen them or fix the joint"
            yield warning(subject, "zero-limits", problem)
        elif c.initial < c.lower or c.initial > c.upper:
            problem = f"initial value {c.initial!r} is outside {c.lower!r} .. {c.upper!r}"
            yield warning(subject, "initial-outside-limits", problem)


def _loops(above: dict[str, Joint]) -> list[list[str]]:
    """The loops of links that are met on the way up from any link.

    Args:
        above: The joint that carries each link.
    """
    loops = []
    met: set[str] = set()
    for start in above:
        path: dict[str, None] = {}
        link = start
        while link in above and link not in met:
            met.add(link)
            path[link] = None
            link = above[link].parent
        if link in path:
            links = list(path)
            loops.append(links[links.index(link) :])
    return loops
