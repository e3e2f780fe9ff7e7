"""Writer of joints and coordinates in OpenSim.

A joint of up to three translations, followed by up to three rotations, becomes a CustomJoint, with
the axes and functions of the motions. Joints about or along OpenSim's default axes become pins and
sliders. A joint with another order of motions becomes a chain, see `joint_chains`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple
from xml.etree import ElementTree

from ....model.function import ITSELF
from ....model.joint import Coordinate, Joint, Motion
from ....model.pose import AXES, Vector3, X, Z
from ....model.robot import Robot
from ....transforms.ellipsoid_joints import OverEllipsoid, over_ellipsoid
from ....transforms.joint_chains import Names, single_joints
from ...writing.xml_text import element, numbers
from .bodies import add_frame, add_massless
from .functions import add_function, can_write_sum

PINS: dict[tuple[str, Vector3], str] = {
    ("rotation", Z): "PinJoint",
    ("translation", X): "SliderJoint",
}
Ranges = Mapping[str, tuple[float, float]]


class Axis(NamedTuple):
    """Axis of a CustomJoint.

    Attributes:
        direction: Direction in the joint frame.
        motions: Motions about or along the axis, which are added; empty for a constant axis.
    """

    direction: Vector3
    motions: tuple[Motion, ...] = ()


def custom_axes(joint: Joint) -> dict[str, Axis] | None:
    """Return the six axes of a CustomJoint by name; None if the joint cannot be a CustomJoint."""
    kinds = [motion.kind for motion in joint.motions]
    if kinds != sorted(kinds, reverse=True):  # translations are before rotations
        return None
    axes: dict[str, Axis] = {}
    for kind in ("rotation", "translation"):
        groups = _about_axes([m for m in joint.motions if m.kind == kind])
        if len(groups) > 3 or not all(map(_is_one_axis, groups)):
            return None
        for k, direction in enumerate(_directions([group[0].axis for group in groups])):
            group = tuple(groups[k]) if k < len(groups) else ()
            axes[f"{kind}{k + 1}"] = Axis(direction, group)
    return axes


def is_one_joint(joint: Joint) -> bool:
    """Return whether OpenSim can hold the joint as a single joint."""
    return custom_axes(joint) is not None or over_ellipsoid(joint.motions) is not None


def has_three_rotations(joint: Joint) -> bool:
    """Return whether three rotations of one OpenSim joint follow one coordinate."""
    turned = Counter(m.coordinate for m in joint.motions if m.kind == "rotation" and not m.is_fixed)
    return max(turned.values(), default=0) >= 3 and is_one_joint(joint)


def is_chain(joint: Joint) -> bool:
    """Return whether a joint can be written as a chain of single joints."""
    moved = [motion.coordinate for motion in joint.motions if not motion.is_fixed]
    return sorted(moved) == list(range(len(joint.coordinates)))


def add_joints(
    joints: ElementTree.Element, bodies: ElementTree.Element, robot: Robot, ranges: Ranges
) -> None:
    """Add the joints, and bodies between the single joints of chains.

    Args:
        joints: Parent element of the joints.
        bodies: Parent element of the bodies.
        ranges: Ranges of coordinates without limits that move points within a range.
    """
    chained = {joint.name: not is_one_joint(joint) for joint in robot.joints}
    names = Names(name for name, split in chained.items() if not split)
    links = {link.name for link in robot.links}
    singles = iter(single_joints(robot))
    for joint in robot.joints:
        parts = [next(singles) for _ in range(max(1, len(joint.motions)))]
        if not chained[joint.name]:
            _add_joint(joints, joint, ranges)
            continue
        for single in parts:
            if single.child not in links:
                add_massless(bodies, single.child)
            _add_joint(joints, single.joint(names.unique(single.name)), ranges)


def coordinate_paths(joints: ElementTree.Element) -> dict[str, str]:
    """Return the path of each coordinate in the model, by its name."""
    return {
        c.attrib["name"]: f"/jointset/{joint.attrib['name']}/{c.attrib['name']}"
        for joint in joints
        for c in joint.iter("Coordinate")
    }


def add_couplers(constraints: ElementTree.Element, robot: Robot) -> Names:
    """Add a constraint for each coupled coordinate; return the names of the constraints."""
    names = Names()
    for c in robot.all_coordinates:
        if not c.coupling:
            continue
        name = names.unique(f"{c.name}_coupler")
        node = element(constraints, "CoordinateCouplerConstraint", name=name)
        function = element(node, "coupled_coordinates_function")
        add_function(function, [term.function for term in c.coupling])
        words = " ".join(term.coordinate for term in c.coupling)
        element(node, "independent_coordinate_names", words)
        element(node, "dependent_coordinate_name", c.name)
    return names


def _about_axes(motions: Sequence[Motion]) -> list[list[Motion]]:
    """Return groups of consecutive motions about or along the same axis."""
    groups: list[list[Motion]] = []
    for motion in motions:
        if groups and groups[-1][0].axis == motion.axis:
            groups[-1].append(motion)
        else:
            groups.append([motion])
    return groups


def _is_one_axis(group: Sequence[Motion]) -> bool:
    """Return whether OpenSim can hold the sum of these motions about one axis."""
    coordinates = {motion.coordinate for motion in group if not motion.is_fixed}
    is_sum = len(group) == 1 or len(coordinates) == len(group)
    return is_sum and can_write_sum([motion.function for motion in group])


def _directions(directions: list[Vector3]) -> list[Vector3]:
    """Return three linearly independent directions that begin with the given ones."""
    axes = list(directions[:3])
    while len(axes) < 3:
        axes.append(next(x for x in AXES if all(_is_independent(x, other) for other in axes)))
    return axes


def _is_independent(a: Vector3, b: Vector3) -> bool:
    return abs(sum(x * y for x, y in zip(a, b, strict=True))) < 0.95 * math.hypot(*b)


def _add_joint(joints: ElementTree.Element, joint: Joint, ranges: Ranges) -> None:
    ellipsoid = over_ellipsoid(joint.motions)
    kind = "WeldJoint" if not joint.motions else _pin_class(joint) or "CustomJoint"
    if ellipsoid is not None:
        kind = "EllipsoidJoint" if ellipsoid.winging is None else "ScapulothoracicJoint"
    node = element(joints, kind, name=joint.name)
    element(node, "socket_parent_frame", "parent_offset")
    element(node, "socket_child_frame", "child_offset")
    if joint.coordinates:
        coordinates = element(node, "coordinates")
        for c in joint.coordinates:
            _add_coordinate(coordinates, c, ranges)
    frames = element(node, "frames")
    add_frame(frames, "parent_offset", joint.parent, joint.T_parent_joint)
    add_frame(frames, "child_offset", joint.child, joint.T_child_joint)
    if kind == "CustomJoint":
        _add_axes(element(node, "SpatialTransform"), joint)
    if ellipsoid is not None:
        _add_ellipsoid(node, ellipsoid)


def _add_ellipsoid(node: ElementTree.Element, ellipsoid: OverEllipsoid) -> None:
    if ellipsoid.winging is None:
        element(node, "radii_x_y_z", numbers(ellipsoid.radii))
        return
    *origin, direction = ellipsoid.winging
    element(node, "thoracic_ellipsoid_radii_x_y_z", numbers(ellipsoid.radii))
    element(node, "scapula_winging_axis_origin", numbers(origin))
    element(node, "scapula_winging_axis_direction", direction)


def _pin_class(joint: Joint) -> str | None:
    if len(joint.motions) != 1 or joint.motions[0].function != ITSELF:
        return None
    return PINS.get((joint.motions[0].kind, joint.motions[0].axis))


def _add_axes(transform: ElementTree.Element, joint: Joint) -> None:
    for name, axis in (custom_axes(joint) or {}).items():
        node = element(transform, "TransformAxis", name=name)
        moved = [m for m in axis.motions if not m.is_fixed]
        words = " ".join(joint.coordinates[m.coordinate].name for m in moved)
        element(node, "coordinates", words)
        element(node, "axis", numbers(axis.direction))
        if not axis.motions:
            element(element(node, "Constant", name="function"), "value", 0.0)
        else:
            add_function(node, [m.function for m in axis.motions])
            node[-1].set("name", "function")


def _add_coordinate(parent: ElementTree.Element, c: Coordinate, ranges: Ranges) -> None:
    node = element(parent, "Coordinate", name=c.name)
    locked = c.locked or c.lower == c.upper
    element(node, "default_value", c.lower if locked and not c.locked else c.initial)
    limited = c.is_limited
    low, high = (c.lower, c.upper) if limited else ranges.get(c.name, (c.lower, c.upper))
    element(node, "range", numbers((low, high)))
    element(node, "clamped", _bool_text(limited and (locked or c.lower <= c.initial <= c.upper)))
    element(node, "locked", _bool_text(locked))


def _bool_text(value: bool) -> str:
    return "true" if value else "false"
