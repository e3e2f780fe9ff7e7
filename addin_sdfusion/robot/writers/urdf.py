"""Writer of URDF: links, inertias, joints, limits, damping, meshes.

The root link is called `world`. A joint that moves has the name of its coordinate, so that joint
states by name are q by name; URDF has no order of joints. A joint of several motions becomes a
chain, see `joint_chains`. The frame of a URDF link is that of the joint that carries it: a link
whose frame lies elsewhere is written in that joint's frame, its inertia and meshes with it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from ..finding import Finding, Subject
from ..finding_builders import warning
from ..model.joint import Coordinate
from ..model.pose import IDENTITY, Pose
from ..model.robot import GRAVITY, WORLD, Inertia, Link, Mesh, Robot
from ..model.rotations import apply, compose, inverse, normalized, rotate_inertia, rotation
from ..transforms.joint_chains import SingleJoint, single_joints
from .common_losses import chained_joints, link_ends, names, other_sets
from .file_names import write_document
from .xml_text import document, element, numbers

NO_LIMIT = 1e16
"""The value of a limit that is none: in [rad], [m], [N·m], [N], [rad/s] or [m/s]."""


def write_urdf(robot: Robot, folder: str | Path, name: str | None = None) -> list[Path]:
    """Write `<name>.urdf`; returns and raises as `write_document`."""
    return write_document(robot, folder, name, "urdf", _urdf)


def urdf_losses(robot: Robot) -> list[Finding]:
    """What URDF cannot hold of a valid robot; it refuses none."""
    return [
        *chained_joints(robot, "URDF"),
        *_muscles(robot),
        *_moved_frames(robot),
        *_coordinates(robot),
        *_renamed_joints(robot),
        *link_ends(robot, "URDF"),
        *other_sets(robot, "URDF"),
        *names(robot, "URDF", (j for j in robot.joints if j.motions), sets=False),
    ]


def _muscles(robot: Robot) -> Iterator[Finding]:
    subject = Subject("robot", robot.name)
    if robot.muscles:
        problem = f"URDF has no muscles; {len(robot.muscles)} are left out"
        yield warning(subject, "muscles-left-out", problem)
    if robot.wrap_surfaces:
        problem = f"URDF has no wrap surfaces; {len(robot.wrap_surfaces)} are left out"
        yield warning(subject, "wrap-surfaces-left-out", problem)
    if robot.task_frames:
        problem = f"URDF has no task frames; {len(robot.task_frames)} are left out"
        yield warning(subject, "task-frames-left-out", problem)
    if robot.gravity != GRAVITY:
        problem = f"URDF has no gravity; set {robot.gravity} in [m/s²] where it is used"
        yield warning(subject, "gravity-left-out", problem)


def _moved_frames(robot: Robot) -> Iterator[Finding]:
    for joint in robot.joints:
        if joint.T_child_joint != IDENTITY:
            problem = f"its URDF frame is that of joint {joint.name!r}, not its own"
            yield warning(Subject("link", joint.child), "link-frame-moved", problem)


def _coordinates(robot: Robot) -> Iterator[Finding]:
    for c in robot.coordinates:
        subject = Subject("coordinate", c.name)
        if c.initial:
            problem = f"URDF has no initial values; {c.initial!r} {c.unit} is left out"
            yield warning(subject, "initial-left-out", problem)
        if c.actuated:
            problem = "URDF has no motors; its motor is left out, its torque bounds are efforts"
            yield warning(subject, "motor-left-out", problem)
        if c.tau_min != -c.tau_max:
            problem = f"URDF has one effort for both ways; {_effort(c)!r} is written"
            yield warning(subject, "one-sided-effort", problem)
        if c.stiffness:
            yield warning(subject, "spring-left-out", "URDF has no springs; its spring is left out")
        if _is_limited(c) and not (math.isfinite(c.lower) and math.isfinite(c.upper)):
            problem = f"URDF limits both sides or none; the open one is {NO_LIMIT!r}"
            yield warning(subject, "one-sided-limit", problem)


def _renamed_joints(robot: Robot) -> Iterator[Finding]:
    given = {single.child: single.name for single in single_joints(robot)}
    for joint in robot.joints:
        if joint.type == "fixed" and given[joint.child] != joint.name:
            problem = f"a coordinate has its name; written as {given[joint.child]!r}"
            yield warning(Subject("joint", joint.name), "renamed", problem)


def _urdf(robot: Robot) -> str:
    root = element(None, "robot", name=robot.name)
    element(root, "link", name=WORLD)
    links = {link.name: link for link in robot.links}
    singles = single_joints(robot)
    for single in singles:
        if single.child in links:
            _link(root, links[single.child], inverse(single.T_child_joint))
        else:
            _inertial(element(root, "link", name=single.child), Inertia(0.0), IDENTITY)
    T_link_joint = {single.child: single.T_child_joint for single in singles}
    for single in singles:
        parent = T_link_joint.get(single.parent, IDENTITY)
        _joint(root, single, compose(inverse(parent), single.T_parent_joint))
    return document(root)


def _link(root: ElementTree.Element, link: Link, T_joint_link: Pose) -> None:
    node = element(root, "link", name=link.name)
    _inertial(node, link.inertia, T_joint_link)
    for mesh in link.meshes:
        _mesh(node, mesh, T_joint_link)


def _inertial(link: ElementTree.Element, inertia: Inertia, T_joint_link: Pose) -> None:
    """Zeros are written as well: a link without `inertial` weighs 1 kg to DART."""
    node = element(link, "inertial")
    _origin(node, Pose(apply(T_joint_link, inertia.com)))
    element(node, "mass", value=numbers([inertia.mass]))
    matrix = inertia.matrix
    if any(T_joint_link.rpy):
        matrix = rotate_inertia(rotation(T_joint_link.rpy), matrix)
    (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = matrix
    entries = {"ixx": ixx, "ixy": ixy, "ixz": ixz, "iyy": iyy, "iyz": iyz, "izz": izz}
    element(node, "inertia", None, **{entry: numbers([x]) for entry, x in entries.items()})


def _mesh(link: ElementTree.Element, mesh: Mesh, T_joint_link: Pose) -> None:
    node = element(link, mesh.role, **({"name": mesh.name} if mesh.name else {}))
    _origin(node, compose(T_joint_link, mesh.pose))
    element(element(node, "geometry"), "mesh", filename=mesh.uri, scale=numbers(mesh.scale))


def _joint(root: ElementTree.Element, single: SingleJoint, origin: Pose) -> None:
    node = element(root, "joint", name=single.name, type=_type(single))
    _origin(node, origin)
    element(node, "parent", link=single.parent)
    element(node, "child", link=single.child)
    if single.motion is None or single.coordinate is None:
        return
    c = single.coordinate
    element(node, "axis", xyz=numbers(normalized(single.motion.axis)))
    effort = {"effort": _effort(c), "velocity": NO_LIMIT}
    if node.get("type") != "continuous":
        limits = {"lower": max(c.lower, -NO_LIMIT), "upper": min(c.upper, NO_LIMIT)} | effort
        element(node, "limit", None, **{key: numbers([value]) for key, value in limits.items()})
    elif effort["effort"] < NO_LIMIT:
        element(node, "limit", None, **{key: numbers([value]) for key, value in effort.items()})
    friction = {"friction": numbers([c.friction])} if c.friction else {}
    element(node, "dynamics", damping=numbers([c.damping]), **friction)


def _type(single: SingleJoint) -> str:
    if single.motion is None or single.coordinate is None:
        return "fixed"
    if single.motion.kind == "translation":
        return "prismatic"
    return "revolute" if _is_limited(single.coordinate) else "continuous"


def _effort(coordinate: Coordinate) -> float:
    return min(max(abs(coordinate.tau_min), abs(coordinate.tau_max)), NO_LIMIT)


def _is_limited(coordinate: Coordinate) -> bool:
    return math.isfinite(coordinate.lower) or math.isfinite(coordinate.upper)


def _origin(parent: ElementTree.Element, pose: Pose) -> None:
    element(parent, "origin", xyz=numbers(pose.position), rpy=numbers(pose.rpy))
