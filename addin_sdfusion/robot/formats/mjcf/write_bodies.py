"""Links and joints in MJCF: nested bodies with hinges and slides.

MuJoCo's joints of one body move one after another, about axes that the first ones turn. A motion
that counts from another zero has a `ref`; one that stands still is a part of the places of the
others. Every other motion but the first of a coordinate is a joint of its own, which an equality
makes follow.
"""

from __future__ import annotations

import math
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
from ..capability import Found
from ..writing.xml_text import element, numbers
from .write_inertia import mjcf_inertia

MAX_NESTED = 480
"""MuJoCo's XML reader takes 500 elements inside each other."""
TYPES = {"rotation": "hinge", "translation": "slide"}


def add_body(robot: Robot, joint: Joint, parent: ElementTree.Element) -> ElementTree.Element:
    """Add the child of a joint to its parent's body.

    Returns:
        The child's body, in the child link's own frame.
    """
    frames = _motion_frames(joint)
    T_parent_child = compose(joint.T_parent_joint, inverse(frames[0]))
    body = element(parent, "body", None, name=joint.child, **placement(T_parent_child))
    for mover, T_child_motion in zip(movers(robot)[joint.name], frames, strict=False):
        if mover.name:
            _add_motion(body, mover, T_child_motion)
    link = robot.link(joint.child)
    inertia = mjcf_inertia(link, moving=bool(joint.motions))
    if inertia is not None:
        _add_inertial(body, inertia)
    return body


def placement(pose: Pose) -> dict[str, str]:
    """The attributes of a pose; the file's `eulerseq` makes the angles roll, pitch and yaw."""
    return {"pos": numbers(pose.position), "euler": numbers(pose.rpy)}


@dataclass(frozen=True)
class Mover:
    """A motion, and MuJoCo's joint that makes it.

    Attributes:
        name: Of MuJoCo's joint; empty if the motion stands still.
        motion: The motion.
        coordinate: What drives it.
        is_home: Whether MuJoCo's joint is that coordinate; else it follows it.
        ref: The value of MuJoCo's joint where the way is 0.
    """

    name: str
    motion: Motion
    coordinate: Coordinate
    is_home: bool
    ref: float


def movers(robot: Robot) -> dict[str, list[Mover]]:
    """What makes the motions of each joint, by the joint's name."""
    names = Names(c.name for c in robot.all_coordinates)
    return {joint.name: list(_movers(joint, names)) for joint in robot.joints}


def coordinate_order(robot: Robot) -> list[Mover]:
    """MuJoCo's joints in its order: bodies depth first, motions in a row."""
    carried: dict[str, list[Joint]] = {}
    for joint in robot.joints:
        carried.setdefault(joint.parent, []).append(joint)
    made = movers(robot)
    order: list[Mover] = []
    waiting = list(reversed(carried.get(WORLD, [])))
    while waiting:
        joint = waiting.pop()
        order += [mover for mover in made[joint.name] if mover.name]
        waiting += reversed(carried.get(joint.child, []))
    return order


def too_deep(robot: Robot) -> Iterator[Found]:
    """The first links of chains that are longer than MuJoCo reads."""
    depths = {WORLD: 0}
    for joint in robot.joints:
        depths[joint.child] = depths[joint.parent] + 1
    return (Found(Subject("link", n)) for n, depth in depths.items() if depth == MAX_NESTED + 1)


def _movers(joint: Joint, names: Names) -> Iterator[Mover]:
    homes: set[int] = set()
    for k, motion in enumerate(joint.motions, start=1):
        c = joint.coordinates[motion.coordinate] if joint.coordinates else Coordinate("")
        if motion.is_fixed:
            yield Mover("", motion, c, is_home=False, ref=0.0)
            continue
        offset = motion.way(0.0)
        plain = motion.function in (ITSELF, linear(1.0, offset))
        is_home = plain and motion.coordinate not in homes
        if is_home:
            homes.add(motion.coordinate)
            yield Mover(c.name, motion, c, is_home=True, ref=-offset if offset else 0.0)
        else:
            yield Mover(names.give(f"{joint.name}_{k}"), motion, c, is_home=False, ref=0.0)


def _motion_frames(joint: Joint) -> list[Pose]:
    """T_child_motion of each motion, then of the end of all, before anything has moved."""
    frames = [joint.T_child_joint]
    for motion in reversed(joint.motions):
        T = frames[-1]
        if motion.is_fixed:
            T = compose(T, inverse(fixed_pose(motion)))
        frames.append(T)
    return [*reversed(frames[1:]), frames[0]]


def _add_motion(body: ElementTree.Element, mover: Mover, T_child_motion: Pose) -> None:
    c, motion = mover.coordinate, mover.motion
    axis = rotate(rotation(T_child_motion.rpy), normalized(motion.axis))
    words = {"pos": numbers(T_child_motion.position), "axis": numbers(axis)}
    if mover.is_home:
        if c.lower < c.upper and (math.isfinite(c.lower) or math.isfinite(c.upper)):
            words |= {"limited": "true", "range": numbers((c.lower, c.upper))}
        words |= {"damping": numbers([c.damping])} | _resisting(c)
        if mover.ref:
            words["ref"] = numbers([mover.ref])
    element(body, "joint", None, name=mover.name, type=TYPES[motion.kind], **words)


def _resisting(c: Coordinate) -> dict[str, str]:
    """Return the attributes of a spring, an armature and friction, if there are any."""
    given = {}
    if c.stiffness:
        given = {"stiffness": numbers([c.stiffness]), "springref": numbers([c.rest])}
    if c.armature:
        given["armature"] = numbers([c.armature])
    return given | ({"frictionloss": numbers([c.friction])} if c.friction else {})


def _add_inertial(body: ElementTree.Element, inertia: Inertia) -> None:
    i = inertia
    element(
        body,
        "inertial",
        pos=numbers(i.com),
        mass=numbers([i.mass]),
        fullinertia=numbers((i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz)),
    )
