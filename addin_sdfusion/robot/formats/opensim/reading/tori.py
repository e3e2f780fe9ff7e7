"""OpenSim's tori, as cylinders.

OpenSim leads a path through a torus's hole over a cylinder that touches the tube from within,
where a ring of twice the radius is nearest to the straight line; in every pose again. Here that of
the model's first pose stays where it is, so that lengths have derivatives; each path has its own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

from ....checks.check import check
from ....finding import Subject
from ....model.coupling import all_values
from ....model.function import value
from ....model.link_poses import link_poses
from ....model.muscle import Muscle, ViaPoint, Wrap, WrapSurface
from ....model.pose import Pose, Vector3
from ....model.robot import Robot
from ....model.rotations import add, apply, compose, dot, inverse, subtract
from ....model.transform import Transform
from ...reading.xml import Node

COUNTED = 2.0
"""OpenSim's slope of the distance to the ring counts the radius double."""
AROUND = 64
"""So many places of the ring are looked at first."""
HALVINGS = 60
MIN_RATIO = 1e-12
"""A line that is as short as this, in [m], has no direction."""

Segment = tuple[Vector3, Vector3]


class Torus(NamedTuple):
    """A torus about the z axis of its pose.

    Attributes:
        node: Its element.
        link: What it is fixed to.
        pose: In the frame of the link.
        tube: Radius of the tube, in [m].
        ring: Radius of the ring in its middle, in [m].
    """

    node: Node
    link: str
    pose: Pose
    tube: float
    ring: float


def with_cylinders(robot: Robot, tori: Mapping[str, Torus]) -> Robot:
    """Return the robot with cylinders in the place of the tori that muscles wrap over.

    Args:
        robot: Some of its wraps may be over tori, by their names.
        tori: The tori by name.
    """
    if not any(wrap.surface in tori for muscle in robot.muscles for wrap in muscle.wraps):
        return robot
    bodies = replace(robot, cable_sets=(), cable_set="")
    is_sound = not any(finding.is_error for finding in check(bodies))
    places = _Places(robot) if is_sound else None
    surfaces = list(robot.wrap_surfaces)
    muscles = []
    for muscle in robot.muscles:
        wraps = []
        for wrap in muscle.wraps:
            if wrap.surface not in tori:
                wraps.append(wrap)
                continue
            torus = tori[wrap.surface]
            cylinder = None if places is None else _cylinder(torus, muscle, wrap, places)
            if cylinder is not None:
                surfaces.append(cylinder)
                wraps.append(replace(wrap, surface=cylinder.name, quadrant="+x"))
        muscles.append(replace(muscle, wraps=tuple(wraps)))
    cables = tuple(replace(cables, muscles=tuple(muscles)) for cables in robot.cable_sets)
    return replace(robot, cable_sets=cables, wrap_surfaces=tuple(surfaces))


class _Places:
    """Where things are in the first pose."""

    def __init__(self, robot: Robot) -> None:
        initial = {c.name: c.initial for c in robot.coordinates}
        self._values = all_values(robot, initial)
        self._poses = link_poses(robot, initial)

    def segments(self, torus: Torus, muscle: Muscle, wrap: Wrap) -> Iterator[Segment]:
        """The segments that may wrap, in the torus's frame."""
        T_torus_world = inverse(compose(self._poses[torus.link], torus.pose))
        points = muscle.via_points[wrap.segment : wrap.last + 2]
        places = [
            apply(T_torus_world, apply(self._poses[point.link], self._position(point)))
            for point in points
            if point.when is None
            or point.when.low <= self._values[point.when.coordinate] <= point.when.high
        ]
        return pairwise(places)

    def _position(self, point: ViaPoint) -> Vector3:
        place = point.position
        for move in point.moves:
            q = min(max(self._values[move.coordinate], move.low), move.high)
            place = add(place, _times(value(move.function, q), move.axis))
        return place


def _cylinder(torus: Torus, muscle: Muscle, wrap: Wrap, places: _Places) -> WrapSurface | None:
    """The cylinder of a muscle; None, which is noted, if it does not pass through the hole."""
    segments = list(places.segments(torus, muscle, wrap))
    through = [(_beside(a, b), a, b) for a, b in segments if a[2] * b[2] < 0.0]
    name, node = (
        torus.node.attribute("name"),
        replace(torus.node, subject=Subject("muscle", muscle.name)),
    )
    if not through:
        problem = f"it does not pass through torus {name!r} in the model's first pose"
        node.warning("wrap-left-out", f"{problem}: it goes straight there")
        return None
    _, a, b = min(through)
    angle = _nearest(COUNTED * torus.ring, a, b)
    c, s = math.cos(angle), math.sin(angle)
    at = (torus.ring * c, torus.ring * s, 0.0)
    own = Transform(((-c, 0.0, -s), (-s, 0.0, c), (0.0, 1.0, 0.0)), at)
    problem = (
        f"it goes through torus {name!r} over a cylinder, where OpenSim has it in the first pose; "
        "OpenSim moves that along the ring with the pose: elsewhere lengths differ, by some mm"
    )
    node.warning("torus-as-cylinder", problem)
    pose = compose(torus.pose, own.pose())
    return WrapSurface(f"{name}_{muscle.name}", torus.link, "cylinder", torus.tube, pose)


def _beside(a: Vector3, b: Vector3) -> float:
    """How far from the middle of the hole a line meets the plane of the ring."""
    t = a[2] / (a[2] - b[2])
    return math.hypot(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))


def _nearest(ring: float, a: Vector3, b: Vector3) -> float:
    """Return the angle at which a ring about z is nearest to a line."""
    along = subtract(b, a)

    def distance(angle: float) -> float:
        p = (ring * math.cos(angle), ring * math.sin(angle), 0.0)
        t = dot(along, subtract(p, a)) / max(dot(along, along), MIN_RATIO * MIN_RATIO)
        return math.dist(p, add(a, _times(t, along)))

    step = 2.0 * math.pi / AROUND
    best = min((k * step for k in range(AROUND)), key=distance)
    for _ in range(HALVINGS):
        step *= 0.5
        best = min((best - step, best, best + step), key=distance)
    return best


def _times(factor: float, v: Vector3) -> Vector3:
    return factor * v[0], factor * v[1], factor * v[2]
