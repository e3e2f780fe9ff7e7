"""Writer of links and joints in MJCF: nested bodies with hinges and slides.

The joints of a body in MuJoCo act in sequence, about axes rotated by the previous ones. A motion
with an offset gets a `ref`. A constant motion is included in the poses of the others. The first
motion of a coordinate is the joint of that coordinate. Every other motion becomes a separate joint,
which an equality couples to the coordinate.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree import ElementTree

from ...finding import Subject
from ...model.function import ITSELF, linear
from ...model.joint import Coordinate, Joint, Motion
from ...model.pose import Pose
from ...model.robot import WORLD, Inertia, Robot
from ...model.rotations import compose, inverse, normalized, rotate, rotation
from ...transforms.joint_chains import Names, fixed_pose
from ..capability import FeaturePlace
from ..writing.xml_text import element, numbers
from .write_inertia import mjcf_inertia

MAX_NESTED = 480
"""Maximum depth; the XML reader of MuJoCo supports 500 nested elements."""
TYPES = {"rotation": "hinge", "translation": "slide"}


def add_body(robot: Robot, joint: Joint, parent: ElementTree.Element) -> ElementTree.Element:
    """Add the child of a joint to the body of its parent.

    Returns:
        The body of the child, in the frame of the child link.
    """
    frames = _motion_frames(joint)
    T_parent_child = compose(joint.T_parent_joint, inverse(frames[0]))
    body = element(parent, "body", None, name=joint.child, **placement(T_parent_child))
    for motion_joint, T_child_motion in zip(motion_joints(robot)[joint.name], frames, strict=False):
        if motion_joint.name:
            _add_motion(body, motion_joint, T_child_motion)
    link = robot.link(joint.child)
    inertia = mjcf_inertia(link, moving=bool(joint.motions))
    if inertia is not None:
        _add_inertial(body, inertia)
    return body


def placement(pose: Pose) -> dict[str, str]:
    """Return the attributes of a pose; `eulerseq` of the file selects roll, pitch and yaw."""
    return {"pos": numbers(pose.position), "euler": numbers(pose.rpy)}


@dataclass(frozen=True)
class MotionJoint:
    """Motion and the MuJoCo joint that represents it.

    Attributes:
        name: Name of the MuJoCo joint; empty if the motion is constant.
        coordinate: Coordinate that drives the motion.
        is_home: Whether the MuJoCo joint is the coordinate itself; otherwise it is coupled to it.
        ref: Value of the MuJoCo joint at which the motion is zero.
    """

    name: str
    motion: Motion
    coordinate: Coordinate
    is_home: bool
    ref: float


def motion_joints(robot: Robot) -> dict[str, list[MotionJoint]]:
    """Return the MuJoCo joints of the motions of each joint, by joint name."""
    names = Names(c.name for c in robot.all_coordinates)
    return {joint.name: list(_motion_joints(joint, names)) for joint in robot.joints}


def coordinate_order(robot: Robot) -> list[MotionJoint]:
    """Return the MuJoCo joints in its order: bodies depth first, then motions in sequence."""
    children: dict[str, list[Joint]] = {}
    for joint in robot.joints:
        children.setdefault(joint.parent, []).append(joint)
    motions_of = motion_joints(robot)
    order: list[MotionJoint] = []
    waiting = list(reversed(children.get(WORLD, [])))
    while waiting:
        joint = waiting.pop()
        order += [motion_joint for motion_joint in motions_of[joint.name] if motion_joint.name]
        waiting += reversed(children.get(joint.child, []))
    return order


def chains_too_deep(robot: Robot) -> Iterator[FeaturePlace]:
    """Report the first links of chains that exceed the maximum depth of MuJoCo."""
    depths = {WORLD: 0}
    for joint in robot.joints:
        depths[joint.child] = depths[joint.parent] + 1
    return (
        FeaturePlace(Subject("link", n)) for n, depth in depths.items() if depth == MAX_NESTED + 1
    )


def _motion_joints(joint: Joint, names: Names) -> Iterator[MotionJoint]:
    homes: set[int] = set()
    for k, motion in enumerate(joint.motions, start=1):
        c = joint.coordinates[motion.coordinate] if joint.coordinates else Coordinate("")
        if motion.is_fixed:
            yield MotionJoint("", motion, c, is_home=False, ref=0.0)
            continue
        offset = motion.displacement(0.0)
        plain = motion.function in (ITSELF, linear(1.0, offset))
        is_home = plain and motion.coordinate not in homes
        if is_home:
            homes.add(motion.coordinate)
            yield MotionJoint(c.name, motion, c, is_home=True, ref=-offset if offset else 0.0)
        else:
            yield MotionJoint(names.unique(f"{joint.name}_{k}"), motion, c, is_home=False, ref=0.0)


def _motion_frames(joint: Joint) -> list[Pose]:
    """Return T_child_motion of each motion, then of the end of the chain, at zero motion."""
    frames = [joint.T_child_joint]
    for motion in reversed(joint.motions):
        T = frames[-1]
        if motion.is_fixed:
            T = compose(T, inverse(fixed_pose(motion)))
        frames.append(T)
    return [*reversed(frames[1:]), frames[0]]


def _add_motion(body: ElementTree.Element, motion_joint: MotionJoint, T_child_motion: Pose) -> None:
    c, motion = motion_joint.coordinate, motion_joint.motion
    axis = rotate(rotation(T_child_motion.rpy), normalized(motion.axis))
    words = {"pos": numbers(T_child_motion.position), "axis": numbers(axis)}
    if motion_joint.is_home:
        if c.lower < c.upper and c.is_limited:
            words |= {"limited": "true", "range": numbers((c.lower, c.upper))}
        words |= {"damping": numbers([c.damping])} | _resistance_attributes(c)
        if motion_joint.ref:
            words["ref"] = numbers([motion_joint.ref])
    element(body, "joint", None, name=motion_joint.name, type=TYPES[motion.kind], **words)


def _resistance_attributes(c: Coordinate) -> dict[str, str]:
    """Return the attributes of spring, armature and friction that are not zero."""
    attributes = {}
    if c.stiffness:
        attributes = {"stiffness": numbers([c.stiffness]), "springref": numbers([c.rest])}
    if c.armature:
        attributes["armature"] = numbers([c.armature])
    return attributes | ({"frictionloss": numbers([c.friction])} if c.friction else {})


def _add_inertial(body: ElementTree.Element, inertia: Inertia) -> None:
    element(
        body,
        "inertial",
        pos=numbers(inertia.com),
        mass=numbers([inertia.mass]),
        fullinertia=numbers(inertia.entries),
    )
