"""Writer of muscles in MJCF: spatial tendons through sites and over geoms."""

from __future__ import annotations

import math
from xml.etree import ElementTree

from ...model.muscle import Muscle, Wrap, WrapSurface
from ...model.robot import Robot
from ...model.rotations import apply
from ...transforms.joint_chains import Names
from ..writing.wrap_side import side_direction
from ..writing.xml_text import element, numbers
from .write_bodies import placement
from .write_muscles import SPRING, spring_attributes

DRAWN_LENGTH = 20.0
"""Drawn length of an infinite cylinder, as a multiple of its radius."""
RULE = "mujoco"
SIDE_DISTANCE = 1.5
"""Distance of a side site from the axis, as a multiple of the radius."""
WRAP_GROUP = "3"

Bodies = dict[str, ElementTree.Element]


def add_wrap_geoms(robot: Robot, bodies: Bodies) -> None:
    """Add the wrap surfaces to their bodies, as geoms without collisions."""
    for surface in _written_surfaces(robot):
        size = [surface.radius]
        if surface.shape == "cylinder":
            endless = math.isinf(surface.length)
            size.append((DRAWN_LENGTH * surface.radius if endless else surface.length) / 2)
        element(
            bodies[surface.link],
            "geom",
            None,
            name=surface.name,
            type=surface.shape,
            size=numbers(size),
            **placement(surface.pose),
            contype="0",
            conaffinity="0",
            group=WRAP_GROUP,
        )


def add_tendons(robot: Robot, root: ElementTree.Element, bodies: Bodies, sites: Names) -> None:
    """Add a tendon for every muscle, and the sites on its path."""
    tendons = element(root, "tendon")
    for muscle in robot.muscles:
        words = spring_attributes(muscle) if muscle.model.kind == SPRING else {}
        if not muscle.via_points:
            _add_fixed(tendons, muscle, words)
            continue
        tendon = element(tendons, "spatial", None, name=muscle.name, **words)
        wraps = _written_wraps(robot, muscle)
        pulleys = {branch.point: branch.divisor for branch in muscle.branches}
        for k, point in enumerate(muscle.via_points):
            if k in pulleys:
                element(tendon, "pulley", divisor=numbers([pulleys[k]]))
            site = sites.unique(f"{muscle.name}:{k}")
            element(bodies[point.link], "site", name=site, pos=numbers(point.position))
            element(tendon, "site", site=site)
            if k in wraps:
                _add_wrap(robot, muscle, wraps[k], tendon, bodies, sites)


def _add_fixed(tendons: ElementTree.Element, muscle: Muscle, words: dict[str, str]) -> None:
    tendon = element(tendons, "fixed", None, name=muscle.name, **words)
    for term in muscle.terms:
        element(tendon, "joint", joint=term.coordinate, coef=numbers([term.factor]))


def _written_surfaces(robot: Robot) -> list[WrapSurface]:
    return [surface for surface in robot.wrap_surfaces if surface.shape != "ellipsoid"]


def _written_wraps(robot: Robot, muscle: Muscle) -> dict[int, Wrap]:
    """Return the wraps in `first_wraps` whose surface is written."""
    names = {surface.name for surface in _written_surfaces(robot)}
    return {k: wrap for k, wrap in first_wraps(muscle).items() if wrap.surface in names}


def first_wraps(muscle: Muscle) -> dict[int, Wrap]:
    """Return the first wrap of each segment, by the index of the via point before it."""
    return {wrap.segment: wrap for wrap in reversed(muscle.wraps)}


def _add_wrap(
    robot: Robot,
    muscle: Muscle,
    wrap: Wrap,
    tendon: ElementTree.Element,
    bodies: Bodies,
    sites: Names,
) -> None:
    surface = robot.wrap_surface(wrap.surface)
    side = {}
    if wrap.side_point is not None:
        side = {"sidesite": sites.unique(f"{muscle.name}:{wrap.segment}:side")}
        link, at = wrap.side_point.link, wrap.side_point.position
        element(bodies[link], "site", name=side["sidesite"], pos=numbers(at))
    elif wrap.side or wrap.inside:
        x, y, z = (0.0, 0.0, 0.0) if wrap.inside else side_direction(robot, muscle, wrap)
        distance = SIDE_DISTANCE * surface.radius
        place = apply(surface.pose, (distance * x, distance * y, distance * z))
        side = {"sidesite": sites.unique(f"{muscle.name}:{wrap.segment}:side")}
        element(bodies[surface.link], "site", name=side["sidesite"], pos=numbers(place))
    element(tendon, "geom", None, geom=surface.name, **side)
