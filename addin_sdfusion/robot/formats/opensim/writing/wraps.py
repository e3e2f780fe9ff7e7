"""Wrap objects in OpenSim, and what muscles do with them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from xml.etree import ElementTree

from ....finding import Subject
from ....model.muscle import Muscle, Quadrant, Wrap, WrapSurface
from ....model.robot import Robot
from ....model.rotations import multiply, rotation
from ....transforms.joint_chains import Names
from ...capability import Found
from ...writing.wrap_side import is_shorter_path, side_direction
from ...writing.xml_text import element, numbers
from .bodies import objects, placement

ENDLESS = 100.0
"""In [m]: length of a cylinder without ends."""
SHAPES = {"sphere": "WrapSphere", "cylinder": "WrapCylinder", "ellipsoid": "WrapEllipsoid"}
RULE = "opensim"

WrapNames = dict[tuple[str, int], str]
"""Of the wrap object of every wrap, by muscle and index."""


def wrap_names(robot: Robot) -> WrapNames:
    """Return the wrap object of every wrap, by muscle and index.

    A half of space, so a chosen side too, belongs to the object in OpenSim: wraps with another one
    than most have over that surface have an object of their own.
    """
    names = Names(surface.name for surface in robot.wrap_surfaces)
    usual = _usual_quadrants(robot)
    return {
        (muscle.name, k): wrap.surface
        if not wrap.side and wrap.quadrant == usual.get(wrap.surface, "all")
        else names.give(f"{wrap.surface}_{muscle.name}")
        for muscle in robot.muscles
        for k, wrap in enumerate(muscle.wraps)
    }


def add_surfaces(robot: Robot, bodies: dict[str, ElementTree.Element]) -> None:
    """Add the wrap objects to the bodies of their links."""
    usual, sets = _usual_quadrants(robot), dict[str, ElementTree.Element]()
    for surface in robot.wrap_surfaces:
        if surface.link not in sets:
            sets[surface.link] = objects(bodies[surface.link], "WrapObjectSet", "wrapobjectset")
        _add_surface(sets[surface.link], surface.name, surface, usual.get(surface.name, "all"))
    for (of, k), name in wrap_names(robot).items():
        muscle = robot.muscle(of)
        wrap = muscle.wraps[k]
        surface = robot.wrap_surface(wrap.surface)
        if wrap.side:
            angle = _side_angle(robot, muscle, wrap, surface)
            quadrant: Quadrant = "all" if angle is None else "+x"
            _add_surface(sets[surface.link], name, surface, quadrant, angle or 0.0)
        elif name != wrap.surface:
            _add_surface(sets[surface.link], name, surface, wrap.quadrant)


def add_wraps(path: ElementTree.Element, muscle: Muscle, names: WrapNames) -> None:
    """Add the wraps of a muscle to its path."""
    wraps = objects(path, "PathWrapSet", "pathwrapset")
    for k, wrap in enumerate(muscle.wraps):
        if wrap.inside:
            continue
        item = element(wraps, "PathWrap", name=f"wrap_{k + 1}")
        element(item, "wrap_object", names[muscle.name, k])
        element(item, "method", "hybrid")
        element(item, "range", f"{wrap.segment + 1} {wrap.last + 2}")


def approximated(robot: Robot) -> Iterator[Found]:
    """Muscles over cylinders and ellipsoids, whose paths OpenSim approximates."""
    spheres = {s.name for s in robot.wrap_surfaces if s.shape == "sphere"}
    for muscle in robot.muscles:
        over = [w for w in muscle.wraps if not w.inside and w.surface not in spheres]
        if over:
            tapers = ", and does not taper their ends" * any(wrap.rule != RULE for wrap in over)
            words = {"tapers": tapers, "names": ", ".join(repr(wrap.surface) for wrap in over)}
            yield Found(Subject("muscle", muscle.name), words)


def shares_segments(muscle: Muscle) -> bool:
    """Return whether a muscle wraps over several surfaces in one segment."""
    outer = [wrap for wrap in muscle.wraps if not wrap.inside]
    return len({wrap.segment for wrap in outer}) < len(outer)


def _side_angle(robot: Robot, muscle: Muscle, wrap: Wrap, surface: WrapSurface) -> float | None:
    """None on the shorter path round a sphere: OpenSim goes through it if a side is chosen."""
    if surface.shape == "sphere" and is_shorter_path(robot, muscle, wrap):
        return None
    x, y, _ = side_direction(robot, muscle, wrap)
    return math.atan2(y, x)


def _usual_quadrants(robot: Robot) -> dict[str, Quadrant]:
    """Return the quadrant in which most paths over each surface pass."""
    counts: dict[str, Counter[Quadrant]] = {}
    for muscle in robot.muscles:
        for wrap in muscle.wraps:
            counts.setdefault(wrap.surface, Counter())[wrap.quadrant] += 1
    return {name: count.most_common(1)[0][0] for name, count in counts.items()}


def _add_surface(
    parent: ElementTree.Element,
    name: str,
    surface: WrapSurface,
    quadrant: Quadrant,
    angle: float = 0.0,
) -> None:
    """A chosen side is that of the x axis, so the object is turned there by an angle."""
    node = element(parent, SHAPES[surface.shape], name=name)
    R = multiply(rotation(surface.pose.rpy), rotation((0.0, 0.0, angle)))
    placement(node, ("translation", "xyz_body_rotation"), surface.pose.position, R)
    element(node, "quadrant", quadrant.removeprefix("+"))
    if surface.half_axes is not None:
        element(node, "dimensions", numbers((surface.radius, *surface.half_axes)))
        return
    element(node, "radius", surface.radius)
    if surface.shape == "cylinder":
        element(node, "length", min(surface.length, ENDLESS))
