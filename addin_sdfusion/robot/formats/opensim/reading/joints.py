"""Reader of OpenSim joints: each class as a sequence of motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ....model.function import ITSELF
from ....model.joint import Coordinate, Joint, Motion, MotionKind
from ....model.pose import Vector3, X, Y, Z
from ....model.robot import WORLD
from ....model.rotations import normalized
from ....transforms.ellipsoid_joints import OverEllipsoid
from ...reading.xml import Node
from .coordinates import read_coordinate
from .document import text
from .frames import Frames, pose_of
from .functions import read_terms

CUSTOM = "CustomJoint"

Moves = tuple[tuple[MotionKind, Vector3, int], ...]
_BALL: Moves = (("rotation", X, 0), ("rotation", Y, 1), ("rotation", Z, 2))
CLASSES: dict[str, Moves] = {
    "WeldJoint": (),
    "PinJoint": (("rotation", Z, 0),),
    "SliderJoint": (("translation", X, 0),),
    "UniversalJoint": (("rotation", X, 0), ("rotation", Y, 1)),
    "GimbalJoint": _BALL,
    "BallJoint": _BALL,
    "PlanarJoint": (("translation", X, 1), ("translation", Y, 2), ("rotation", Z, 0)),
    "FreeJoint": (
        ("translation", X, 3),
        ("translation", Y, 4),
        ("translation", Z, 5),
        *_BALL,
    ),
}
"""Kind, axis and coordinate of each motion; translations are in the parent frame."""


def _scapulothoracic(node: Node) -> tuple[Motion, ...]:
    origin = node.optional("scapula_winging_axis_origin")
    x, y = (0.0, 0.0) if origin is None else origin.numbers(2)
    direction = node.number("scapula_winging_axis_direction", 0.0)
    radii = node.vector("thoracic_ellipsoid_radii_x_y_z")
    return OverEllipsoid(radii, (x, y, direction)).motions()


ELLIPSOID_JOINTS: dict[str, Callable[[Node], tuple[Motion, ...]]] = {
    "EllipsoidJoint": lambda node: OverEllipsoid(node.vector("radii_x_y_z")).motions(),
    "ScapulothoracicJoint": _scapulothoracic,
}
"""Joints that move over an ellipsoid."""
ANGULAR_VELOCITY_JOINTS = ("BallJoint", "FreeJoint", *ELLIPSOID_JOINTS)
DEFAULT_NAMES = {6: ("rx", "ry", "rz", "tx", "ty", "tz"), 3: ("rx", "ry", "rz")}
AXES = {
    "translation1": X,
    "translation2": Y,
    "translation3": Z,
    "rotation1": X,
    "rotation2": Y,
    "rotation3": Z,
}
"""Axes in the order of the motions: translations in the parent frame, then rotations."""


def read_joint(node: Node, frames: Frames) -> Joint:
    """Return a joint with its coordinates."""
    name = node.subject.name
    joint_path = f"/jointset/{name}"
    parent, T_parent_joint = frames.place(node, "socket_parent_frame", joint_path)
    child, T_child_joint = frames.place(node, "socket_child_frame", joint_path)
    if child == WORLD:
        problem = "its child is the ground; make the ground the parent"
        node.error("reversed-joint", problem)
    named = [c for group in node.all("coordinates") for c in group.all("Coordinate")]
    if node.tag == CUSTOM:
        motions = _custom(node, [c.attribute("name") for c in named])
    elif node.tag in CLASSES:
        motions = tuple(Motion(*move) for move in CLASSES[node.tag])
    elif node.tag in ELLIPSOID_JOINTS:
        motions = ELLIPSOID_JOINTS[node.tag](node)
    else:
        choices = (CUSTOM, *CLASSES, *ELLIPSOID_JOINTS)
        node.error("unsupported-joint", f"unsupported <{node.tag}>", choices)
        motions = ()
    if node.tag in ANGULAR_VELOCITY_JOINTS:
        problem = (
            "its speeds are the rates of its three angles; in OpenSim they are the angular "
            "velocity; the motion is the same"
        )
        node.warning("speeds-of-angles", problem)
    units = _units(motions, len(named))
    coordinates = tuple(read_coordinate(c, unit) for c, unit in zip(named, units, strict=True))
    coordinates += _unlisted_coordinates(name, motions, coordinates)
    return Joint(
        name,
        parent,
        child,
        motions,
        coordinates,
        pose_of(T_parent_joint),
        pose_of(T_child_joint),
    )


def free_joint(link: Node, used_names: Sequence[str]) -> Joint:
    """Return the joint of a body without a parent joint: as in OpenSim, it moves freely."""
    link_name = link.subject.name
    name = f"{link_name}_free"
    while name in used_names:
        name += "_"
    link.warning(
        "freed-body", "has no parent joint; it moves freely relative to the ground, as in OpenSim"
    )
    motions = tuple(Motion(*move) for move in CLASSES["FreeJoint"])
    joint = Joint(name, WORLD, link_name, motions)
    return replace(joint, coordinates=_unlisted_coordinates(name, motions, ()))


def _units(motions: Sequence[Motion], count: int) -> list[str]:
    """Return the unit of each coordinate, from its first motion, preferably without function."""
    units: list[str] = []
    for k in range(count):
        related = [m for m in motions if m.coordinate == k and not m.is_fixed]
        plain = [m for m in related if m.function == ITSELF]
        units.append((plain or related or [Motion("rotation", X)])[0].unit)
    return units


def _unlisted_coordinates(
    joint: str, motions: Sequence[Motion], named: Sequence[Coordinate]
) -> tuple[Coordinate, ...]:
    """Return coordinates that the file does not list, with the values and names of OpenSim."""
    count = max((m.coordinate + 1 for m in motions if not m.is_fixed), default=0)
    words = DEFAULT_NAMES.get(count, tuple(map(str, range(count))))
    units = {m.coordinate: m.unit for m in motions if not m.is_fixed}
    return tuple(
        Coordinate(f"{joint}_{words[k]}" if count > 1 else joint, unit=units.get(k, "rad"))
        for k in range(len(named), count)
    )


def _custom(node: Node, names: list[str]) -> tuple[Motion, ...]:
    """Return the motions of a CustomJoint, without constant motions of zero."""
    transform = node.required("SpatialTransform")
    axes = [] if transform is None else transform.all("TransformAxis")
    by_name = {axis.attribute("name", ""): axis for axis in axes}
    motions: list[Motion] = []
    for name, default in AXES.items():
        if name in by_name:
            kind: MotionKind = "rotation" if name.startswith("r") else "translation"
            motions += _about_axis(by_name[name], kind, default, names)
    for name, axis in by_name.items():
        if name not in AXES:
            axis.error("unknown-axis", f"unknown <TransformAxis> {name!r}", AXES)
    return tuple(motions)


def _about_axis(node: Node, kind: MotionKind, default: Vector3, names: list[str]) -> list[Motion]:
    """Return the motions of one axis: one for each term of its function."""
    axis = normalized(node.vector("axis")) if node.all("axis") else default
    functions = [child for child in node.all() if child.tag not in ("coordinates", "axis")]
    if functions and functions[0].tag == "function":
        functions = functions[0].all()
    if not functions:
        return []
    words = text(node, "coordinates").split()
    motions = []
    for name, function in read_terms(functions[0], words):
        if name and name not in names:
            problem = f"<TransformAxis>: unknown coordinate {name!r}"
            node.error("unknown-coordinate", problem, names)
            continue
        motion = Motion(kind, axis, names.index(name) if name else 0, function)
        if not (motion.is_fixed and motion.displacement(0.0) == 0.0):
            motions.append(motion)
    return motions
