"""Reader of the joints of SDF models."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from ...finding import Subject
from ...model.joint import Coordinate, Joint, Motion, MotionKind
from ...model.pose import AXES, Pose, Vector3, Z
from ...model.robot import WORLD
from ...model.rotations import compose, inverse, normalized, rotate, rotation
from ..reading.xml import TRUE, Node, short_repr
from .names import NO_LIMIT, joint_frame_name
from .read_frames import MODEL, Frames

JOINT_TYPES: dict[str, tuple[MotionKind, ...]] = {
    "revolute": ("rotation",),
    "continuous": ("rotation",),
    "prismatic": ("translation",),
    "universal": ("rotation", "rotation"),
    "revolute2": ("rotation", "rotation"),
    "ball": ("rotation", "rotation", "rotation"),
    "fixed": (),
}
"""Motions of the supported joint types."""
BALL = ("alpha", "beta", "gamma")
"""Angles of a ball joint, which has no coordinates in SDF: Rx(alpha) Ry(beta) Rz(gamma)."""


@dataclass(frozen=True)
class Model:
    """Data of a model that its joints are read with."""

    frames: Frames
    T_world_model: Pose
    version: str


def read_joint(node: Node, model: Model) -> Joint:
    """Return a joint; its coordinates have its name, with a suffix if there are several."""
    name, type_ = node.subject.name, node.attribute("type")
    parent = _link_named(node, "parent", model.frames)
    child = _link_named(node, "child", model.frames)
    if type_ not in JOINT_TYPES:
        node.error("unsupported-joint", f"unsupported joint type {short_repr(type_)}", JOINT_TYPES)
        type_ = "fixed"
    joint = Joint(
        name,
        parent,
        child,
        T_parent_joint=_in_parent(name, parent, model),
        T_child_joint=_in_child(name, child, model.frames),
    )
    if type_ == "ball":
        return _ball(joint, node)
    kinds = JOINT_TYPES[type_]
    motions, coordinates = [], []
    for k, (tag, kind) in enumerate(zip(("axis", "axis2"), kinds, strict=False)):
        called = name if len(kinds) == 1 else f"{name}_{k + 1}"
        about = node.with_subject(Subject("coordinate", called))
        axis = about.required(tag)
        motions.append(Motion(kind, _axis_in_joint(axis, name, model), k))
        coordinate = Coordinate(called, unit=motions[k].unit)
        coordinates.append(coordinate if axis is None else _with_limits(axis, coordinate))
    if type_ == "continuous":
        coordinates = [replace(c, lower=-math.inf, upper=math.inf) for c in coordinates]
    return replace(joint, motions=tuple(motions), coordinates=tuple(coordinates))


def _ball(joint: Joint, node: Node) -> Joint:
    motions = tuple(Motion("rotation", axis, k) for k, axis in enumerate(AXES))
    names = [f"{joint.name}_{angle}" for angle in BALL]
    for name in names:
        node.with_subject(Subject("coordinate", name))
    return replace(joint, motions=motions, coordinates=tuple(map(Coordinate, names)))


def _link_named(node: Node, tag: str, frames: Frames) -> str:
    child = node.required(tag)
    if child is None:
        return ""
    return child.text if child.text == WORLD else frames.link_of(child.text)


def _in_parent(name: str, parent: str, model: Model) -> Pose:
    """Return T_parent_joint, without rounding errors if the file defines it directly."""
    key, frames = ("joint", name), model.frames
    if parent == WORLD:
        return compose(model.T_world_model, frames.in_model(key))
    if frames.placements[key].relative_to == ("link", parent):
        return frames.placements[key].pose
    return compose(inverse(frames.in_model(("link", parent))), frames.in_model(key))


def _in_child(name: str, child: str, frames: Frames) -> Pose:
    """Return T_child_joint, without rounding errors if the file defines it directly."""
    key, link = ("joint", name), ("link", child)
    exact = frames.placements.get(("frame", joint_frame_name(name, child)))
    if exact is not None and exact.relative_to == link:
        return exact.pose
    if frames.placements[key].relative_to == link:
        return frames.placements[key].pose
    if link in frames.placements and frames.placements[link].relative_to == key:
        return inverse(frames.placements[link].pose)
    return compose(inverse(frames.in_model(link)), frames.in_model(key))


def _with_limits(axis: Node, coordinate: Coordinate) -> Coordinate:
    limit, dynamics = axis.optional("limit"), axis.optional("dynamics")
    _note_not_simulated(axis, limit)

    def number(tag: str) -> float:
        return dynamics.number(tag, 0.0) if dynamics else 0.0

    effort = _bound(limit, "effort")

    return replace(
        coordinate,
        lower=_limit(limit, "lower", -math.inf),
        upper=_limit(limit, "upper", math.inf),
        initial=axis.number("initial_position", 0.0),
        damping=number("damping"),
        stiffness=number("spring_stiffness"),
        rest=number("spring_reference"),
        friction=number("friction"),
        tau_min=-effort,
        tau_max=effort,
        max_velocity=_bound(limit, "velocity"),
    )


def _note_not_simulated(axis: Node, limit: Node | None) -> None:
    if limit is not None and _bound(limit, "velocity") < math.inf:
        limit.warning("joint-not-simulated", "its velocity limit is not simulated")
    if axis.all("mimic"):
        axis.warning("joint-not-simulated", "<mimic> is ignored; the joint moves independently")


def _bound(limit: Node | None, tag: str) -> float:
    """Return a maximum effort or velocity; a negative value in SDF means no limit."""
    bound = -1.0 if limit is None else limit.number(tag, -1.0, infinite=True)
    return bound if 0.0 <= bound < NO_LIMIT else math.inf


def _limit(limit: Node | None, tag: str, default: float) -> float:
    value = default if limit is None else limit.number(tag, default, infinite=True)
    return math.copysign(math.inf, value) if abs(value) >= NO_LIMIT else value


def _axis_in_joint(axis: Node | None, joint: str, model: Model) -> Vector3:
    """Return the unit axis in the joint frame, transformed from the frame in the file."""
    xyz = None if axis is None else axis.required("xyz")
    if axis is None or xyz is None:
        return Z
    # Before SDF 1.5 an axis is always expressed in the model frame.
    in_model = "1" if model.version == "1.4" else "0"
    flag = axis.optional("use_parent_model_frame")
    named = xyz.attribute("expressed_in", "")
    vector = normalized(xyz.vector3())
    if named:
        key = model.frames.named(named)
        if key is None:
            problem = f"expressed_in {short_repr(named)} does not exist as link, joint or frame"
            xyz.error("unknown-frame", problem)
            return vector
        T_model_frame = model.frames.in_model(key)
    elif (flag.text if flag else in_model) in TRUE:
        T_model_frame = model.frames.in_model(MODEL)
    else:
        return vector
    T_joint_frame = compose(inverse(model.frames.in_model(("joint", joint))), T_model_frame)
    return rotate(rotation(T_joint_frame.rpy), vector)
