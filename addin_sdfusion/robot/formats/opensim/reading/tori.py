"""Approximation of OpenSim's tori by cylinders.

OpenSim routes a path through the hole of a torus over a cylinder. The cylinder touches the tube
from inside where a ring of twice the radius is nearest to the straight line, in every pose. Here
the cylinder of the initial pose is fixed, so that lengths are differentiable. Each path has a
separate cylinder.
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
from ....model.rotations import add, apply, compose, dot, inverse, scale, subtract
from ....model.transform import Transform
from ...reading.xml import Node

RING_FACTOR = 2.0
"""In OpenSim the derivative of the distance to the ring uses twice the radius."""
RING_SAMPLES = 64
"""Number of initial samples on the ring."""
HALVINGS = 60
MIN_RATIO = 1e-12
"""Length in [m] below which a line has no direction."""

Segment = tuple[Vector3, Vector3]


class Torus(NamedTuple):
    """Torus about the z axis of its pose.

    Attributes:
        link: Link that it is fixed to.
        pose: Pose in the frame of the link.
        tube: Radius of the tube, in [m].
        ring: Radius of the centre line of the tube, in [m].
    """

    node: Node
    link: str
    pose: Pose
    tube: float
    ring: float


def with_cylinders(robot: Robot, tori: Mapping[str, Torus]) -> Robot:
    """Return the robot with cylinders instead of the tori that muscles wrap over.

    Args:
        robot: The robot; its wraps may refer to tori by name.
    """
    if not any(wrap.surface in tori for muscle in robot.muscles for wrap in muscle.wraps):
        return robot
    bodies = replace(robot, cable_sets=(), cable_set="")
    is_sound = not any(finding.is_error for finding in check(bodies))
    places = _InitialPositions(robot) if is_sound else None
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


class _InitialPositions:
    """Positions of muscle points in the initial pose."""

    def __init__(self, robot: Robot) -> None:
        initial = {c.name: c.initial for c in robot.coordinates}
        self._values = all_values(robot, initial)
        self._poses = link_poses(robot, initial)

    def segments(self, torus: Torus, muscle: Muscle, wrap: Wrap) -> Iterator[Segment]:
        """Yield the segments that may wrap, in the frame of the torus."""
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
            place = add(place, scale(value(move.function, q), move.axis))
        return place


def _cylinder(
    torus: Torus, muscle: Muscle, wrap: Wrap, places: _InitialPositions
) -> WrapSurface | None:
    """Return the cylinder of a muscle; None, with a warning, if it does not pass the hole."""
    segments = list(places.segments(torus, muscle, wrap))
    through = [(_distance_from_centre(a, b), a, b) for a, b in segments if a[2] * b[2] < 0.0]
    name, node = (
        torus.node.attribute("name"),
        replace(torus.node, subject=Subject("muscle", muscle.name)),
    )
    if not through:
        problem = f"it does not pass through torus {name!r} in the initial pose"
        node.warning("wrap-left-out", f"{problem}; its path is straight there")
        return None
    _, a, b = min(through)
    angle = _nearest(RING_FACTOR * torus.ring, a, b)
    c, s = math.cos(angle), math.sin(angle)
    at = (torus.ring * c, torus.ring * s, 0.0)
    offset = Transform(((-c, 0.0, -s), (-s, 0.0, c), (0.0, 1.0, 0.0)), at)
    problem = (
        f"torus {name!r} is read as a cylinder, at its position in the initial pose; in OpenSim "
        "the cylinder moves along the ring with the pose; lengths differ by some mm in other "
        "poses"
    )
    node.warning("torus-as-cylinder", problem)
    pose = compose(torus.pose, offset.pose())
    return WrapSurface(f"{name}_{muscle.name}", torus.link, "cylinder", torus.tube, pose)


def _distance_from_centre(a: Vector3, b: Vector3) -> float:
    """Return the distance from the centre at which a line crosses the plane of the ring, in [m]."""
    t = a[2] / (a[2] - b[2])
    return math.hypot(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))


def _nearest(ring: float, a: Vector3, b: Vector3) -> float:
    """Return the angle in [rad] at which a ring about z is nearest to a line."""
    along = subtract(b, a)

    def distance(angle: float) -> float:
        p = (ring * math.cos(angle), ring * math.sin(angle), 0.0)
        t = dot(along, subtract(p, a)) / max(dot(along, along), MIN_RATIO * MIN_RATIO)
        return math.dist(p, add(a, scale(t, along)))

    step = 2.0 * math.pi / RING_SAMPLES
    best = min((k * step for k in range(RING_SAMPLES)), key=distance)
    for _ in range(HALVINGS):
        step *= 0.5
        best = min((best - step, best, best + step), key=distance)
    return best
