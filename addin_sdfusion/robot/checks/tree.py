"""Checks of the joint tree: order, axes, coordinates, limits and motors."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence

from ..finding import Finding, Subject
from ..finding_builders import error, finite, listed, unknown, warning
from ..model.function import ITSELF
from ..model.joint import Joint
from ..model.loop import LoopJoint
from ..model.pose import Vector3
from ..model.robot import WORLD, Robot

AXIS_TOLERANCE = 1e-6
MAX_NAMES = 20
"""Maximum number of links that an error about a loop lists."""
DEGREES = 3.0 * math.tau, 720.0
"""Joint limits in this range are probably in degrees; larger ones mean an unlimited joint."""


def joint_ends(robot: Robot) -> Iterator[Finding]:
    """Check that parent and child of every joint exist."""
    return link_ends(robot, robot.joints)


def link_ends(robot: Robot, joints: Sequence[Joint] | Sequence[LoopJoint]) -> Iterator[Finding]:
    """Check that parent and child of joints or loop joints exist."""
    links = [link.name for link in robot.links]
    children, parents = set(links), {WORLD, *links}
    for joint in joints:
        subject = Subject("joint", joint.name)
        if joint.parent not in parents:
            problem = f"parent: {unknown('link', joint.parent, [WORLD, *links])}"
            yield error(subject, "unknown-parent", problem)
        if joint.child not in children:
            yield error(subject, "unknown-child", f"child: {unknown('link', joint.child, links)}")


def one_parent_each(robot: Robot) -> Iterator[Finding]:
    """Check that every link is the child of exactly one joint."""
    counts = Counter(joint.child for joint in robot.joints)
    for name in dict.fromkeys(link.name for link in robot.links):
        subject = Subject("link", name)
        if counts[name] == 0:
            problem = f"no joint connects it to a parent; fix it to {WORLD!r} or to another link"
            yield error(subject, "no-parent", problem)
        if counts[name] > 1:
            joints = ", ".join(repr(joint.name) for joint in robot.joints if joint.child == name)
            problem = f"is the child of several joints: {joints}; a robot is a tree; keep one"
            yield error(subject, "two-parents", problem)


def parents_first(robot: Robot) -> Iterator[Finding]:
    """Check that every joint comes after the joint that moves its parent."""
    above = {joint.child: joint for joint in reversed(robot.joints)}
    looped = {link for loop in _loops(above) for link in loop}
    placed = {WORLD}
    for joint in robot.joints:
        if joint.parent not in placed and joint.parent in above and joint.child not in looped:
            problem = (
                f"comes before joint {above[joint.parent].name!r}, which moves its parent; "
                "list parents first"
            )
            yield error(Subject("joint", joint.name), "joint-order", problem)
        placed.add(joint.child)


def no_loops(robot: Robot) -> Iterator[Finding]:
    """Check that the joints do not form a loop."""
    above = {joint.child: joint for joint in reversed(robot.joints)}
    for loop in _loops(above):
        links = listed(loop, MAX_NAMES)
        subject = Subject("joint", above[loop[0]].name)
        yield error(subject, "closed-loop", f"closes a loop of links {links}; a robot is a tree")


def axes(robot: Robot) -> Iterator[Finding]:
    """Check that axes are unit vectors."""
    for joint in robot.joints:
        for motion in joint.motions:
            yield from unit_axis(Subject("joint", joint.name), motion.axis)


def unit_axis(subject: Subject, axis: Vector3) -> Iterator[Finding]:
    """Check that a finite axis is a unit vector."""
    norm = math.hypot(*axis)
    if norm == 0.0:
        yield error(subject, "zero-axis", "the axis is zero; give it a direction")
    elif finite(axis) and abs(norm - 1.0) > AXIS_TOLERANCE:
        problem = f"the axis has length {norm:g}; divide it by this length"
        yield error(subject, "axis-not-unit", problem)


def coordinates(robot: Robot) -> Iterator[Finding]:
    """Check that every motion has a coordinate and vice versa, and that units agree."""
    for joint in robot.joints:
        subject = Subject("joint", joint.name)
        moving = [motion for motion in joint.motions if not motion.is_fixed]
        driven = sorted({motion.coordinate for motion in moving})
        if driven != list(range(len(joint.coordinates))):
            problem = (
                f"its {len(joint.motions)} motions are driven by coordinates {driven} of "
                f"{len(joint.coordinates)}; every coordinate needs a motion, and no other index"
            )
            yield error(subject, "wrong-coordinates", problem)
            continue
        for motion in moving:
            coordinate = joint.coordinates[motion.coordinate]
            if motion.function == ITSELF and coordinate.unit != motion.unit:
                problem = f"{coordinate.name!r} drives a {motion.kind}, so its unit must be "
                yield error(subject, "wrong-unit", f"{problem}{motion.unit}, not {coordinate.unit}")


def limits(robot: Robot) -> Iterator[Finding]:
    """Check joint limits and initial values, and that passive parameters are not negative."""
    for c in robot.all_coordinates:
        subject = Subject("coordinate", c.name)
        for name in ("damping", "stiffness", "friction", "armature"):
            if getattr(c, name) < 0.0:
                yield error(subject, f"negative-{name}", f"{name} {getattr(c, name)!r} is negative")
        if not c.max_velocity >= 0.0:
            problem = f"maximum velocity {c.max_velocity!r} must not be negative"
            yield error(subject, "negative-velocity", problem)
        if c.lower > c.upper:
            problem = f"lower limit {c.lower!r} is above the upper limit {c.upper!r}; exchange "
            problem += "them, or remove both if the joint has no limits"
            yield error(subject, "limits-reversed", problem)
        elif not c.is_free:
            continue
        elif c.lower == c.upper == 0.0:
            problem = "both limits are 0, so it cannot move; widen them or use a fixed joint"
            yield warning(subject, "zero-limits", problem)
        elif c.initial < c.lower or c.initial > c.upper:
            problem = f"initial value {c.initial!r} is outside {c.lower!r} .. {c.upper!r}"
            yield warning(subject, "initial-outside-limits", problem)
        farthest = max([abs(x) for x in (c.lower, c.upper) if math.isfinite(x)], default=0.0)
        if c.unit == "rad" and DEGREES[0] < farthest <= DEGREES[1]:
            turns = farthest / math.tau
            problem = f"a limit of {farthest:g} rad is {turns:.3g} turns; is it in degrees?"
            yield warning(subject, "limits-in-degrees", problem)


def motors(robot: Robot) -> Iterator[Finding]:
    """Check that the limits of motors are in order, finite and not both 0."""
    for c in robot.coordinates:
        subject = Subject("coordinate", c.name)
        force = "torque" if c.unit == "rad" else "force"
        if c.tau_min > c.tau_max:
            problem = f"tau_min {c.tau_min!r} of its motor is above tau_max {c.tau_max!r}"
            yield error(subject, "motor-limits-reversed", problem)
        elif c.actuated and c.tau_min == c.tau_max == 0.0:
            problem = f"its motor has no {force}; set its effort, or remove the motor"
            yield error(subject, "motor-without-torque", problem)
        elif c.actuated and (math.isinf(c.tau_min) or math.isinf(c.tau_max)):
            problem = f"its motor has no maximum {force}; set its effort"
            yield warning(subject, "no-motor-limit", problem)


def _loops(above: dict[str, Joint]) -> list[list[str]]:
    """Return the loops of links on the paths from any link to the root."""
    loops = []
    visited: set[str] = set()
    for start in above:
        path: dict[str, None] = {}
        link = start
        while link in above and link not in visited:
            visited.add(link)
            path[link] = None
            link = above[link].parent
        if link in path:
            links = list(path)
            loops.append(links[links.index(link) :])
    return loops
