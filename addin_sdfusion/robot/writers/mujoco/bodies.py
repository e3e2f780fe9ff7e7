"""Links and joints in MJCF: nested bodies with hinges and slides."""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree import ElementTree

from ...finding import Finding, Subject
from ...finding_builders import error
from ...model.joint import Coordinate, Joint, Motion
from ...model.pose import Pose
from ...model.robot import WORLD, Inertia, Robot
from ...model.rotations import compose, inverse, normalized, rotate, rotation
from ..xml_text import element, numbers
from .inertia import mjcf_inertia

MOST_NESTED = 480
"""MuJoCo's XML reader takes 500 elements inside each other."""
TYPES = {"rotation": "hinge", "translation": "slide"}


def add_body(robot: Robot, joint: Joint, parent: ElementTree.Element) -> ElementTree.Element:
    """Add the child of a joint to its parent's body.

    Returns:
        The child's body, in the child link's own frame.
    """
    T_parent_child = compose(joint.T_parent_joint, inverse(joint.T_child_joint))
    body = element(parent, "body", None, name=joint.child, **placement(T_parent_child))
    for motion in joint.motions:
        _add_motion(body, joint, motion)
    link = robot.link(joint.child)
    inertia = mjcf_inertia(link, moving=bool(joint.motions))
    if inertia is not None:
        _add_inertial(body, inertia)
    return body


def placement(pose: Pose) -> dict[str, str]:
    """The attributes of a pose; the file's `eulerseq` makes the angles roll, pitch and yaw."""
    return {"pos": numbers(pose.position), "euler": numbers(pose.rpy)}


def coordinate_order(robot: Robot) -> list[Coordinate]:
    """The coordinates in MuJoCo's order: bodies depth first, motions in a row."""
    carried: dict[str, list[Joint]] = {}
    for joint in robot.joints:
        carried.setdefault(joint.parent, []).append(joint)
    order: list[Coordinate] = []
    waiting = list(reversed(carried.get(WORLD, [])))
    while waiting:
        joint = waiting.pop()
        order += [joint.coordinates[motion.coordinate] for motion in joint.motions]
        waiting += reversed(carried.get(joint.child, []))
    return order


def depth_losses(robot: Robot) -> Iterator[Finding]:
    """Chains that are longer than MuJoCo reads."""
    depths = {WORLD: 0}
    for joint in robot.joints:
        depths[joint.child] = depths[joint.parent] + 1
    for name, depth in depths.items():
        if depth == MOST_NESTED + 1:
            problem = f"MuJoCo reads no chain of more than {MOST_NESTED} links; it is one too far"
            yield error(Subject("link", name), "too-many-nested", problem)


def _add_motion(body: ElementTree.Element, joint: Joint, motion: Motion) -> None:
    """MuJoCo's joints of one body move one after another, about axes that the first ones turn."""
    c = joint.coordinates[motion.coordinate]
    axis = rotate(rotation(joint.T_child_joint.rpy), normalized(motion.axis))
    limits = {}
    if c.lower < c.upper and (math.isfinite(c.lower) or math.isfinite(c.upper)):
        limits = {"limited": "true", "range": numbers((c.lower, c.upper))}
    element(
        body,
        "joint",
        None,
        name=c.name,
        type=TYPES[motion.kind],
        pos=numbers(joint.T_child_joint.position),
        axis=numbers(axis),
        damping=numbers([c.damping]),
        **_resisting(c),
        **limits,
    )


def _resisting(c: Coordinate) -> dict[str, str]:
    """The attributes of a spring, an armature and friction, where there are any."""
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
