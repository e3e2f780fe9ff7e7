"""Reads a robot from an SDF model and the cardsflow.xml beside it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from ..finding import Subject
from ..joint import Coordinate, Joint, Motion, MotionKind
from ..model import WORLD, Inertia, Link, Robot
from ..placement import Pose, Vector3
from ..pose import (
    compose,
    inverse,
    normalized,
    rotate,
    rotate_inertia,
    rotation,
)
from ..sdf import NO_LIMIT, joint_frame_name
from .sdf_extras import read_extras
from .sdf_frames import MODEL, Frames, read_pose
from .xml import Node, Notes, parse, shortened

JOINT_TYPES: dict[str, MotionKind | None] = {
    "revolute": "rotation",
    "prismatic": "translation",
    "fixed": None,
}
VERSIONS = ("1.4", "1.5", "1.6", "1.7")


def read_sdf(file: Path, cable_set: str | None, notes: Notes) -> Robot | None:
    """The robot in an SDF file with one model.

    Muscles come from the plugin's cable sets, as `write_sdf` makes them; without those, from the
    cardsflow.xml beside the file; without that, from muscles directly in the plugin.

    Args:
        file: The SDF file.
        cable_set: The cable set to make active; the file's own choice if None.
        notes: Where findings, places and files go.

    Raises:
        InputError: A file is not readable XML.
        UnknownNameError: There is no such cable set.
    """
    root = parse(file, Subject("robot", file.stem), notes)
    model = _model(root)
    if model is None:
        return None
    model = model.about(Subject("robot", model.attribute("name")))
    frames = Frames(model)
    placed = model.optional("pose")
    T_world_model = Pose() if placed is None else read_pose(placed)
    joints = [
        _joint(_about(node, "joint"), frames, T_world_model, root.attribute("version", ""))
        for node in model.all("joint")
    ]
    joints = _parents_first([*_welds(model, joints, frames, T_world_model), *joints])
    links = [_link(_about(node, "link")) for node in model.all("link")]
    robot = Robot(model.subject.name, tuple(links), tuple(joints))
    return read_extras(robot, model, cable_set)


def _about(node: Node, kind: str) -> Node:
    return node.about(Subject(kind, node.attribute("name")))


def _model(root: Node) -> Node | None:
    """The one model of a file, directly or in a world."""
    if root.tag != "sdf":
        root.error("not-sdf", f"<{root.tag}> is not <sdf>")
        return None
    if root.attribute("version") not in VERSIONS:
        version = shortened(root.attribute("version", ""))
        root.warning("sdf-version", f"SDF {version} is read as SDF {VERSIONS[-1]}")
    models = root.all("model") + [
        node for world in root.all("world") for node in world.all("model")
    ]
    if len(models) != 1:
        root.error("not-one-model", f"the file holds {len(models)} models; give one with one model")
        return None
    for node in models[0].all("model", "include"):
        node.error("unsupported-element", f"<{node.tag}> in a model is not supported")
    return models[0]


def _link(node: Node) -> Link:
    inertial = node.optional("inertial")
    if inertial is None:
        problem = "no <inertial>; SDF's own 1 kg and 1 kg·m² are used"
        node.warning("default-inertial", problem)
        return Link(node.subject.name, Inertia(1.0, ixx=1.0, iyy=1.0, izz=1.0))
    placed = inertial.optional("pose")
    pose = Pose() if placed is None else read_pose(placed)
    return Link(node.subject.name, _inertia(inertial, pose))


def _inertia(inertial: Node, pose: Pose) -> Inertia:
    mass = inertial.number("mass")
    node = inertial.required("inertia")
    if node is None:
        return Inertia(mass, pose.position)
    moments = {entry: node.number(entry) for entry in ("ixx", "iyy", "izz")}
    products = {entry: node.number(entry, 0.0) for entry in ("ixy", "ixz", "iyz")}
    inertia = Inertia(mass, pose.position, **moments, **products)
    if not any(pose.rpy):
        return inertia
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = rotate_inertia(rotation(pose.rpy), inertia.matrix)
    return replace(inertia, ixx=xx, iyy=yy, izz=zz, ixy=xy, ixz=xz, iyz=yz)


def _joint(node: Node, frames: Frames, T_world_model: Pose, version: str) -> Joint:
    name, type_ = node.subject.name, node.attribute("type")
    parent, child = _text(node, "parent"), _text(node, "child")
    if type_ not in JOINT_TYPES:
        known = ", ".join(JOINT_TYPES)
        problem = f"joint type {shortened(type_)} is not supported (supported: {known})"
        node.error("unsupported-joint", problem)
        type_ = "fixed"
    joint = Joint(
        name,
        parent,
        child,
        T_parent_joint=_in_parent(name, parent, frames, T_world_model),
        T_child_joint=_in_child(name, child, frames),
    )
    kind = JOINT_TYPES[type_]
    if kind is None:
        return joint
    return _with_axis(joint, kind, node.about(Subject("coordinate", name)), frames, version)


def _text(node: Node, tag: str) -> str:
    child = node.required(tag)
    return "" if child is None else child.text


def _in_parent(name: str, parent: str, frames: Frames, T_world_model: Pose) -> Pose:
    """T_parent_joint, as it stands in the file if it does."""
    key = ("joint", name)
    if parent == WORLD:
        return compose(T_world_model, frames.in_model(key))
    if frames.placements[key].relative_to == ("link", parent):
        return frames.placements[key].pose
    return compose(inverse(frames.in_model(("link", parent))), frames.in_model(key))


def _in_child(name: str, child: str, frames: Frames) -> Pose:
    """T_child_joint, as it stands in the file if it does."""
    key, link = ("joint", name), ("link", child)
    exact = frames.placements.get(("frame", joint_frame_name(name, child)))
    if exact is not None and exact.relative_to == link:
        return exact.pose
    if frames.placements[key].relative_to == link:
        return frames.placements[key].pose
    if link in frames.placements and frames.placements[link].relative_to == key:
        return inverse(frames.placements[link].pose)
    return compose(inverse(frames.in_model(link)), frames.in_model(key))


def _with_axis(joint: Joint, kind: MotionKind, node: Node, frames: Frames, version: str) -> Joint:
    axis = node.required("axis")
    motion = Motion(kind, (0.0, 0.0, 1.0))
    if axis is None:
        coordinate = Coordinate(joint.name, unit=motion.unit)
        return replace(joint, motions=(motion,), coordinates=(coordinate,))
    limit, dynamics = axis.optional("limit"), axis.optional("dynamics")
    coordinate = Coordinate(
        joint.name,
        lower=_limit(limit, "lower", -math.inf),
        upper=_limit(limit, "upper", math.inf),
        initial=axis.number("initial_position", 0.0),
        damping=dynamics.number("damping", 0.0) if dynamics else 0.0,
        unit=motion.unit,
    )
    motion = replace(motion, axis=_axis_in_joint(axis, joint.name, frames, version))
    return replace(joint, motions=(motion,), coordinates=(coordinate,))


def _limit(limit: Node | None, tag: str, default: float) -> float:
    value = default if limit is None else limit.number(tag, default, infinite=True)
    return math.copysign(math.inf, value) if abs(value) >= NO_LIMIT else value


def _axis_in_joint(axis: Node, joint: str, frames: Frames, version: str) -> Vector3:
    """The unit axis in the joint frame, from whatever frame the file gives it in."""
    xyz = axis.required("xyz")
    if xyz is None:
        return (0.0, 0.0, 1.0)
    # Before SDF 1.5 an axis was always given in the frame of the model.
    in_model = "1" if version == "1.4" else "0"
    flag = axis.optional("use_parent_model_frame")
    named = xyz.attribute("expressed_in", "")
    vector = normalized(xyz.vector3())
    if named:
        key = frames.named(named)
        if key is None:
            xyz.error(
                "unknown-frame", f"expressed_in {named!r}: no link, joint or frame of the name"
            )
            return vector
        T_model_frame = frames.in_model(key)
    elif (flag.text if flag else in_model) in ("1", "true"):
        T_model_frame = frames.in_model(MODEL)
    else:
        return vector
    T_joint_frame = compose(inverse(frames.in_model(("joint", joint))), T_model_frame)
    return rotate(rotation(T_joint_frame.rpy), vector)


def _welds(
    model: Node, joints: Iterable[Joint], frames: Frames, T_world_model: Pose
) -> list[Joint]:
    """Fixed joints to the world for the links that no joint carries."""
    carried = {joint.child for joint in joints}
    taken = {joint.name for joint in joints}
    welds: list[Joint] = []
    for node in model.all("link"):
        name = node.attribute("name")
        if name in carried:
            continue
        carried.add(name)
        joint = f"{WORLD}_to_{name}"
        while joint in taken:
            joint += "_"
        taken.add(joint)
        node = node.about(Subject("joint", joint)).about(Subject("link", name))
        node.warning(
            "welded-root", f"no joint carries it; it is fixed to {WORLD!r} where it stands"
        )
        pose = compose(T_world_model, frames.in_model(("link", name)))
        welds.append(Joint(joint, WORLD, name, T_parent_joint=pose))
    return welds


def _parents_first(joints: list[Joint]) -> list[Joint]:
    """The joints in an order with parents first that moves as few as possible.

    Those that hang on a loop or on nothing come last, for the check to tell.
    """
    ordered: list[Joint] = []
    placed, waiting = {WORLD}, dict[str, list[Joint]]()
    for joint in joints:
        ready = [joint]
        while ready:
            first = ready.pop()
            if first.parent not in placed:
                waiting.setdefault(first.parent, []).append(first)
                continue
            ordered.append(first)
            placed.add(first.child)
            ready += reversed(waiting.pop(first.child, []))
    return ordered + [joint for group in waiting.values() for joint in group]
