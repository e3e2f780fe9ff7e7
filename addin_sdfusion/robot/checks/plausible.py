"""Checks of masses and lengths that are possible, but probably wrong."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from ..finding import Finding, Subject
from ..finding_builders import warning
from ..model.joint import Coordinate
from ..model.link_poses import initial_poses
from ..model.muscle import Muscle
from ..model.pose import Vector3
from ..model.robot import WORLD, Link, Robot
from ..model.rotations import apply
from .loops import rigid_bodies
from .masses import ZERO_INERTIA
from .tree import DEGREES

LONG, THIN = 10.0, 10.0
"""Size in [m], mass per length in [kg/m]: a robot that is longer and lighter causes a warning."""
TINY = 5e-3
"""Size in [m]: a smaller robot causes a warning."""


def plausible(robot: Robot) -> Iterator[Finding]:
    """Check masses and the size of a robot without errors."""
    for link in robot.links:
        yield from _inertia(link)
    bodies = rigid_bodies(robot.joints)
    moving = [link for link in robot.links if bodies[link.name] != WORLD]
    extent, mass = _extent(robot, moving), sum(link.inertia.mass for link in moving)
    size = max([extent, *(link.inertia.radius_of_gyration for link in moving)])
    subject = Subject("robot", robot.name)
    if extent > LONG and 0.0 < mass < THIN * extent:
        problem = f"its moving links extend over {extent:.3g} m with {mass:.3g} kg"
        yield warning(subject, "lengths-in-millimetres", f"{problem}; are the lengths in mm?")
    elif 0.0 < size < TINY:
        problem = f"its moving links extend over only {size:.3g} m; lengths must be in m"
        yield warning(subject, "tiny-robot", problem)
    yield from _bladders(robot)


def _inertia(link: Link) -> Iterator[Finding]:
    """Check that the inertia of a link has the size of its mass."""
    of, gyration = link.inertia, link.inertia.radius_of_gyration
    subject = Subject("link", link.name)
    if of.mass == 0.0 and max(of.ixx, of.iyy, of.izz) > ZERO_INERTIA:
        problem = "has an inertia, but its mass is 0, so it has no weight; set its mass"
        yield warning(subject, "inertia-without-mass", problem)
    if gyration > LONG and of.mass < THIN * gyration:
        problem = (
            f"its inertia at {of.mass:.3g} kg means a radius of gyration of {gyration:.3g} m; "
            "is the mass missing, or are the lengths in mm?"
        )
        yield warning(subject, "lengths-in-millimetres", problem)


def _bladders(robot: Robot) -> Iterator[Finding]:
    """Check that the bladders of McKibben muscles have possible lengths at the initial pose.

    If the path is shorter than the cord, the muscle law uses the length 0.
    """
    plain = [m for m in robot.muscles if m.model.kind == "mckibben" and _is_polyline(m)]
    poses = initial_poses(robot) if plain else {}
    for muscle in plain:
        points = [apply(poses[point.link], point.position) for point in muscle.via_points]
        path = sum(math.dist(a, b) for a, b in pairwise(points))
        values = dict(muscle.model.parameters)
        cord, thread = values.get("cord_length", 0.0), values["thread_length"]
        if not 0.0 < path - cord <= thread:
            problem = (
                f"its path of {path:.3g} m minus its cord_length of {cord:.3g} m is the length of "
                f"the bladder, which must be above 0 and at most its thread_length of "
                f"{thread:.3g} m; its force is wrong at the initial pose"
            )
            yield warning(Subject("muscle", muscle.name), "bladder-length", problem)


def _is_polyline(muscle: Muscle) -> bool:
    is_plain = all(p.when is None and not p.moves for p in muscle.via_points)
    return is_plain and not (muscle.wraps or muscle.branches or muscle.terms or muscle.pulley)


def is_in_degrees(coordinate: Coordinate, value: float) -> bool:
    """Return whether a position, nominally in [rad], is probably in degrees.

    This is the case if it is large, outside the limits of the coordinate, and inside in degrees. A
    coordinate without limits and without motor has the limits of several turns.
    """
    if coordinate.unit != "rad" or not abs(value) <= DEGREES[1]:
        return False
    if not coordinate.is_limited:
        return not coordinate.actuated and abs(value) > DEGREES[0]
    is_outside = not coordinate.lower <= value <= coordinate.upper
    is_inside = coordinate.lower <= math.radians(value) <= coordinate.upper
    return is_outside and is_inside and abs(value) > math.tau


def _extent(robot: Robot, links: list[Link]) -> float:
    """Return the largest extent of origins, centres of mass and via points of links, in [m].

    The robot is in its initial pose.
    """
    places: dict[str, list[Vector3]] = {
        link.name: [(0.0, 0.0, 0.0), *([link.inertia.com] if link.inertia.mass else [])]
        for link in links
    }
    for point in (point for muscle in robot.muscles for point in muscle.via_points):
        if point.link in places:
            places[point.link].append(point.position)
    poses = initial_poses(robot)
    points = [apply(poses[name], p) for name, group in places.items() for p in group]
    return max((max(x) - min(x) for x in zip(*points, strict=True)), default=0.0)
