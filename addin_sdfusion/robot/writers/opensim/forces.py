"""Muscles, wrap surfaces, motors and dampers in OpenSim."""

from __future__ import annotations

import math
from xml.etree import ElementTree

from ...model.muscle import Muscle, Wrap, WrapSurface
from ...model.robot import Robot, find
from ...model.rotations import multiply, rotation
from ...transforms.joint_chains import Names
from ..wrap_side import is_shorter_path, side_direction
from ..xml_text import element, numbers
from .bodies import frame_path, objects, placement
from .muscles import force_element

ENDLESS = 100.0
"""In [m]: length of a cylinder without ends."""
SHAPES = {"sphere": "WrapSphere", "cylinder": "WrapCylinder", "ellipsoid": "WrapEllipsoid"}

Surfaces = list[tuple[str, WrapSurface, float | None]]


def surface_names(robot: Robot) -> dict[tuple[str, int], str]:
    """The wrap object of every wrap, by muscle and index.

    A chosen side belongs to the object in OpenSim, so a wrap with one has an object of its own.
    """
    names = Names(surface.name for surface in robot.wrap_surfaces)
    return {
        (muscle.name, k): names.give(f"{wrap.surface}_{muscle.name}") if wrap.side else wrap.surface
        for muscle in robot.muscles
        for k, wrap in enumerate(muscle.wraps)
    }


def add_surfaces(robot: Robot, bodies: dict[str, ElementTree.Element]) -> None:
    """Add the wrap objects to the bodies of their links."""
    sets: dict[str, ElementTree.Element] = {}
    for name, surface, angle in _objects(robot):
        if surface.link not in sets:
            sets[surface.link] = objects(bodies[surface.link], "WrapObjectSet", "wrapobjectset")
        _add_surface(sets[surface.link], name, surface, angle)


def add_muscle(
    forces: ElementTree.Element, muscle: Muscle, names: dict[tuple[str, int], str]
) -> None:
    """Add a muscle: OpenSim's own where it has one of the kind, else one commanded by tension."""
    node = force_element(forces, muscle)
    path = element(node, "GeometryPath", name="path")
    points = objects(path, "PathPointSet", "pathpointset")
    for k, point in enumerate(muscle.via_points, start=1):
        item = element(points, "PathPoint", name=f"{muscle.name}-P{k}")
        element(item, "socket_parent_frame", frame_path(point.link))
        element(item, "location", numbers(point.position))
    wraps = objects(path, "PathWrapSet", "pathwrapset")
    for k, wrap in enumerate(muscle.wraps):
        if wrap.inside:
            continue
        item = element(wraps, "PathWrap", name=f"wrap_{k + 1}")
        element(item, "wrap_object", names[muscle.name, k])
        element(item, "method", "hybrid")
        element(item, "range", f"{wrap.segment + 1} {wrap.segment + 2}")


def add_joint_forces(forces: ElementTree.Element, robot: Robot, names: Names) -> None:
    """Add a motor where a joint has one, with a control in [N·m] or [N], dampers and springs."""
    for c in robot.motors:
        node = element(forces, "CoordinateActuator", name=names.give(f"{c.name}_motor"))
        for tag, bound in (("min_control", c.tau_min), ("max_control", c.tau_max)):
            if math.isfinite(bound):
                element(node, tag, bound)
        element(node, "coordinate", c.name)
        element(node, "optimal_force", 1.0)
    for c in robot.coordinates:
        if c.damping or c.stiffness:
            node = element(forces, "SpringGeneralizedForce", name=names.give(f"{c.name}_damping"))
            element(node, "coordinate", c.name)
            element(node, "stiffness", c.stiffness)
            element(node, "rest_length", c.rest)
            element(node, "viscosity", c.damping)


def _objects(robot: Robot) -> Surfaces:
    """Name, surface and, where a side is chosen, the side's angle about the z axis, in [rad]."""
    found: Surfaces = [(surface.name, surface, None) for surface in robot.wrap_surfaces]
    for (of, k), name in surface_names(robot).items():
        muscle = robot.muscle(of)
        wrap = muscle.wraps[k]
        if wrap.side:
            surface = find("wrap surface", wrap.surface, robot.wrap_surfaces)
            found.append((name, surface, _side_angle(robot, muscle, wrap, surface)))
    return found


def _side_angle(robot: Robot, muscle: Muscle, wrap: Wrap, surface: WrapSurface) -> float | None:
    """None on the shorter path round a sphere: OpenSim goes through it if a side is chosen."""
    if surface.shape == "sphere" and is_shorter_path(robot, muscle, wrap):
        return None
    x, y, _ = side_direction(robot, muscle, wrap)
    return math.atan2(y, x)


def _add_surface(
    parent: ElementTree.Element, name: str, surface: WrapSurface, angle: float | None
) -> None:
    """A chosen side is that of the x axis, so the object is turned there."""
    node = element(parent, SHAPES[surface.shape], name=name)
    R = multiply(rotation(surface.pose.rpy), rotation((0.0, 0.0, angle or 0.0)))
    placement(node, ("translation", "xyz_body_rotation"), surface.pose.position, R)
    element(node, "quadrant", "all" if angle is None else "+x")
    if surface.half_axes is not None:
        element(node, "dimensions", numbers((surface.radius, *surface.half_axes)))
        return
    element(node, "radius", surface.radius)
    if surface.shape == "cylinder":
        element(node, "length", min(surface.length, ENDLESS))
