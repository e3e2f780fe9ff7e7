"""Via points inside of wrap surfaces, where other programs take another path.

Here a surface shrinks so that it passes through the point, and the length has no jump; OpenSim and
MuJoCo run straight as soon as an end is inside. How far the two are apart depends on the pose: it
is looked for at the initial values of the coordinates and at others within their limits.
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
from ..capability import Found, Row, changed
from .wrap_side import ends_on

POSES = 40
"""How many are looked at next to the initial one."""
MIN_SIZE = 1e-9
"""In [m]: less is no difference."""
WIDE = {"rad": math.pi / 2.0, "m": 0.2}
"""How far from its initial value a coordinate without limits goes."""


def rows(program: str) -> tuple[Row, Row]:
    """What a program does otherwise where an end of a wrap's segment is inside of its surface."""
    return (
        changed(
            "points inside of wrap surfaces",
            "via-point-inside-wrap",
            f"where an end is inside {{surface!r}}, {program} takes a straight path and this "
            "simulation wraps around a smaller surface; {first:.2g} m apart at the initial "
            "values{farther}",
            _inside,
        ),
        changed(
            "points that may come to be inside of wrap surfaces",
            "ends-move-near-wraps",
            "at none of {poses} poses is an end of these inside its wrap surface; at one that is, "
            f"{program} would run straight: {{names}}",
            _unseen,
        ),
    )


def _inside(robot: Robot) -> Iterator[Found]:
    """The wraps of which an end is inside at one of the poses."""
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
        yield Found(Subject("muscle", muscle.name), words)


def _unseen(robot: Robot) -> Iterator[Found]:
    """The muscles with wraps of which no end is inside at a pose, but might be at another."""
    names = {
        muscle.name: None
        for muscle, wrap, sizes in _differences(robot)
        if max(sizes) <= MIN_SIZE and _moving(robot, muscle, wrap)
    }
    if names:
        words = {"poses": POSES + 1, "names": ", ".join(map(repr, names))}
        yield Found(Subject("robot", robot.name), words)


def _differences(robot: Robot) -> Iterator[tuple[Muscle, Wrap, list[float]]]:
    """How far the two paths over each wrap are apart at the poses."""
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
    """Return whether an end inside makes the surface shrink."""
    surface = robot.wrap_surface(wrap.surface)
    return wrap.rule == "taut" and not wrap.inside and surface.shape != "ellipsoid"


def _postures(robot: Robot) -> Iterator[dict[str, float]]:
    """The initial values, and others within the limits."""
    yield {c.name: c.initial for c in robot.coordinates}
    drawn = random.Random(0)
    for _ in range(POSES):
        yield {c.name: drawn.uniform(*_range(c)) for c in robot.coordinates}


def _range(c: Coordinate) -> tuple[float, float]:
    wide = WIDE[c.unit]
    lower = c.lower if math.isfinite(c.lower) else min(c.initial, c.upper) - wide
    return lower, c.upper if math.isfinite(c.upper) else max(c.initial, lower) + wide


def _difference(surface: WrapSurface, wrap: Wrap, A: Vector3, B: Vector3) -> float:
    """How much longer the path over the shrunk surface is than the straight line, in [m].

    Args:
        surface: What it wraps over.
        wrap: The wrap, outside of the surface.
        A: The end before it, in the surface's frame.
        B: The end behind it, likewise.

    Returns:
        0 if no end is inside, and where the straight line clears what is left of the surface.
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
    """Return the radius at a height: a cylinder is tapered beyond its ends."""
    beyond = abs(z) - surface.length / 2.0
    if surface.shape == "sphere" or beyond <= 0.0:
        return surface.radius
    if beyond >= surface.radius:
        return 0.0
    return 0.5 * surface.radius * (1.0 + math.cos(math.pi * beyond / surface.radius))


def _moving(robot: Robot, muscle: Muscle, wrap: Wrap) -> list[Coordinate]:
    """Return the coordinates of q that move an end against the surface."""
    above: dict[str, frozenset[str]] = {WORLD: frozenset()}
    for joint in robot.joints:
        above[joint.child] = above[joint.parent] | {joint.name}
    link = robot.wrap_surface(wrap.surface).link
    ends = muscle.via_points[wrap.segment : wrap.segment + 2]
    between = frozenset[str]().union(*(above[end.link] ^ above[link] for end in ends))
    moved = [c for joint in robot.joints if joint.name in between for c in joint.coordinates]
    names = {term.coordinate for c in moved for term in c.coupling} | {c.name for c in moved}
    return [c for c in robot.coordinates if c.name in names]
