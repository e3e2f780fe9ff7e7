"""Writer of wrap objects and wraps in OpenSim."""

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
from ...capability import FeaturePlace
from ...writing.wrap_side import is_shorter_path, side_direction
from ...writing.xml_text import element, numbers
from .bodies import objects, placement

ENDLESS = 100.0
"""Length of cylinders that are read as infinite, and maximum length to write, in [m]."""
SHAPES = {"sphere": "WrapSphere", "cylinder": "WrapCylinder", "ellipsoid": "WrapEllipsoid"}
RULE = "opensim"

WrapNames = dict[tuple[str, int], str]
"""Name of the wrap object of each wrap, by muscle and index."""


def wrap_names(robot: Robot) -> WrapNames:
    """Return the wrap object of each wrap, by muscle and index.

    In OpenSim the quadrant, and so also a chosen side, belongs to the wrap object. Wraps whose
    quadrant differs from the most frequent one of their surface get a separate object.
    """
    names = Names(surface.name for surface in robot.wrap_surfaces)
    usual = _usual_quadrants(robot)
    return {
        (muscle.name, k): wrap.surface
        if not wrap.side and wrap.quadrant == usual.get(wrap.surface, "all")
        else names.unique(f"{wrap.surface}_{muscle.name}")
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


def approximated_wraps(robot: Robot) -> Iterator[FeaturePlace]:
    """Report muscles over cylinders and ellipsoids, whose paths OpenSim approximates."""
    spheres = {s.name for s in robot.wrap_surfaces if s.shape == "sphere"}
    for muscle in robot.muscles:
        over = [w for w in muscle.wraps if not w.inside and w.surface not in spheres]
        if over:
            tapers = ", and does not taper their ends" * any(wrap.rule != RULE for wrap in over)
            words = {"tapers": tapers, "names": ", ".join(repr(wrap.surface) for wrap in over)}
            yield FeaturePlace(Subject("muscle", muscle.name), words)


def shares_segments(muscle: Muscle) -> bool:
    """Return whether a muscle wraps over several surfaces in one segment."""
    outer = [wrap for wrap in muscle.wraps if not wrap.inside]
    return len({wrap.segment for wrap in outer}) < len(outer)


def _side_angle(robot: Robot, muscle: Muscle, wrap: Wrap, surface: WrapSurface) -> float | None:
    """Return the angle of a side; None on the shorter path around a sphere.

    If a side of a sphere is chosen, OpenSim routes the shorter path through the sphere.
    """
    if surface.shape == "sphere" and is_shorter_path(robot, muscle, wrap):
        return None
    x, y, _ = side_direction(robot, muscle, wrap)
    return math.atan2(y, x)


def _usual_quadrants(robot: Robot) -> dict[str, Quadrant]:
    """Return the most frequent quadrant of the paths over each surface."""
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
    """Add a wrap object, rotated about z so that its x axis points to the chosen side."""
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
