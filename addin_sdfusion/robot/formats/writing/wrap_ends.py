"""Findings on via points inside wrap surfaces, where other programs compute another path.

In this simulation a surface shrinks until it passes through the point, so that the length is
continuous. OpenSim and MuJoCo use a straight line as soon as an end is inside. The difference
depends on the pose. It is evaluated at the initial values of the coordinates and at random values
within their limits.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

from ...finding import Subject
from ...model.joint import Coordinate
from ...model.link_poses import link_poses
from ...model.muscle import Muscle, Wrap, WrapSurface
from ...model.pose import Vector3
from ...model.robot import WORLD, Robot
from ..capability import FeaturePlace, Row, changed
from .wrap_side import ends_on

POSES = 40
"""Number of poses evaluated in addition to the initial one."""
MIN_SIZE = 1e-9
"""Smallest difference in length to report, in [m]."""
UNLIMITED_RANGE = {"rad": math.pi / 2.0, "m": 0.2}
"""Range of a coordinate without limits around its initial value, in [rad] or [m]."""


def rows(program: str) -> tuple[Row, Row]:
    """Return the rows on wraps whose ends are, or may come, inside the wrap surface."""
    return (
        changed(
            "points inside wrap surfaces",
            "via-point-inside-wrap",
            f"where an end is inside {{surface!r}}, {program} takes a straight path and this "
            "simulation wraps around a smaller surface; {first:.2g} m apart at the initial "
            "values{farther}",
            _inner_ends,
        ),
        changed(
            "points that may move inside wrap surfaces",
            "ends-move-near-wraps",
            "at none of {poses} poses an end of these wraps is inside its wrap surface; at other "
            f"poses {program} may use a straight path: {{names}}",
            _possible_inner_ends,
        ),
    )


def _inner_ends(robot: Robot) -> Iterator[FeaturePlace]:
    """Report the wraps with an end inside the surface at one of the poses."""
    for muscle, wrap, sizes in _differences(robot):
        k = max(range(len(sizes)), key=sizes.__getitem__)
        if sizes[k] <= MIN_SIZE:
            continue
        words = {"surface": wrap.surface, "first": sizes[0], "farther": ""}
        if k:
            posture = list(_postures(robot))[k]
            moving = _moving(robot, muscle, wrap)
            place = ", ".join(f"{c.name} = {posture[c.name]:.3g} {c.unit}" for c in moving)
            words["farther"] = f", {sizes[k]:.2g} m at {place}"
        yield FeaturePlace(Subject("muscle", muscle.name), words)


def _possible_inner_ends(robot: Robot) -> Iterator[FeaturePlace]:
    """Report the muscles with wraps whose ends are outside at all poses but can move."""
    names = {
        muscle.name: None
        for muscle, wrap, sizes in _differences(robot)
        if max(sizes) <= MIN_SIZE and _moving(robot, muscle, wrap)
    }
    if names:
        words = {"poses": POSES + 1, "names": ", ".join(map(repr, names))}
        yield FeaturePlace(Subject("robot", robot.name), words)


def _differences(robot: Robot) -> Iterator[tuple[Muscle, Wrap, list[float]]]:
    """Yield the difference between the two paths over each wrap, in [m], at all poses."""
    outer = [(m, wrap) for m in robot.muscles for wrap in m.wraps if _is_smooth(robot, wrap)]
    poses = [link_poses(robot, posture) for posture in _postures(robot)] if outer else []
    for muscle, wrap in outer:
        surface = robot.wrap_surface(wrap.surface)
        yield (
            muscle,
            wrap,
            [_difference(surface, wrap, *ends_on(robot, muscle, wrap, p)) for p in poses],
        )


def _is_smooth(robot: Robot, wrap: Wrap) -> bool:
    """Return whether the surface shrinks if an end is inside."""
    surface = robot.wrap_surface(wrap.surface)
    return wrap.rule == "taut" and not wrap.inside and surface.shape != "ellipsoid"


def _postures(robot: Robot) -> Iterator[dict[str, float]]:
    """Yield the initial values of the coordinates, then random values within the limits."""
    yield {c.name: c.initial for c in robot.coordinates}
    drawn = random.Random(0)
    for _ in range(POSES):
        yield {c.name: drawn.uniform(*c.range(UNLIMITED_RANGE[c.unit])) for c in robot.coordinates}


def _difference(surface: WrapSurface, wrap: Wrap, A: Vector3, B: Vector3) -> float:
    """Return the length of the path over the shrunk surface minus the straight length, in [m].

    Args:
        wrap: The wrap, on the outer side of the surface.
        A: The end before the surface, in the frame of the surface.
        B: The end after the surface, likewise.

    Returns:
        0 if no end is inside, or if the straight line does not touch the shrunk surface.
    """
    h = 0.0
    if surface.shape == "cylinder":
        a, b, h = (A[0], A[1], 0.0), (B[0], B[1], 0.0), B[2] - A[2]
    else:
        a, b = A, B
    ra, rb, across = math.hypot(*a), math.hypot(*b), math.dist(a, b)
    R = min(ra, rb)
    if not 0.0 < R < surface.radius or across == 0.0:
        return 0.0
    inner = sum(x * y for x, y in zip(a, b, strict=True))
    nearest = min(max((ra * ra - inner) / across**2, 0.0), 1.0)  # on the straight line, 0 to 1
    R = min(R, _radius_at(surface, A[2] + nearest * h))
    passes = math.hypot(*(x + nearest * (y - x) for x, y in zip(a, b, strict=True)))
    if R == 0.0 or passes >= R or nearest in (0.0, 1.0):
        return 0.0
    turn = math.acos(max(-1.0, min(1.0, inner / (ra * rb))))
    if surface.shape == "cylinder" and wrap.side * (a[0] * b[1] - a[1] * b[0]) < 0.0:
        turn = 2.0 * math.pi - turn
    angle = turn - math.acos(R / ra) - math.acos(R / rb) + 2.0 * math.pi * wrap.turns
    planar = math.sqrt(ra * ra - R * R) + math.sqrt(rb * rb - R * R) + R * angle
    return math.hypot(planar, h) - math.hypot(across, h)


def _radius_at(surface: WrapSurface, z: float) -> float:
    """Return the radius at height z: a cylinder is tapered beyond its ends."""
    beyond = abs(z) - surface.length / 2.0
    if surface.shape == "sphere" or beyond <= 0.0:
        return surface.radius
    if beyond >= surface.radius:
        return 0.0
    return 0.5 * surface.radius * (1.0 + math.cos(math.pi * beyond / surface.radius))


def _moving(robot: Robot, muscle: Muscle, wrap: Wrap) -> list[Coordinate]:
    """Return the coordinates in q that move an end relative to the surface."""
    above: dict[str, frozenset[str]] = {WORLD: frozenset()}
    for joint in robot.joints:
        above[joint.child] = above[joint.parent] | {joint.name}
    link = robot.wrap_surface(wrap.surface).link
    ends = muscle.via_points[wrap.segment : wrap.segment + 2]
    between = frozenset[str]().union(*(above[end.link] ^ above[link] for end in ends))
    moved = [c for joint in robot.joints if joint.name in between for c in joint.coordinates]
    names = {term.coordinate for c in moved for term in c.coupling} | {c.name for c in moved}
    return [c for c in robot.coordinates if c.name in names]
