"""Reader of URDF, and of the cardsflow.xml next to it.

URDF has links, joints, limits, motors and meshes. What it has no words for, muscles above all,
comes from a cardsflow.xml in the same folder, as `write_urdf` makes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from ...errors import InputError
from ...finding import Subject
from ...model.joint import Joint
from ...model.pose import IDENTITY
from ...model.robot import WORLD, Robot
from ..cardsflow.beside import cardsflow_xml, read_extras
from ..reading.chains import join_chains
from ..reading.distinct import distinct
from ..reading.meshes import note_missing_meshes
from ..reading.tree import parents_first, welds
from ..reading.xml import Node, Notes, parse
from .mujoco_tag import read_mujoco_tag
from .read_joints import read_joint
from .read_links import material_colors, note_shapes, read_link
from .read_motors import motor_joints

XACRO = (
    "is xacro, not yet URDF; `xacro {0} > {1}` writes the URDF (xacro is a package of ROS, and "
    "`pip install xacro` if it is missing)"
)


def read_urdf(file: Path, cable_set: str | None, notes: Notes) -> Robot | None:
    """Return the robot in a URDF file.

    Args:
        file: The URDF file.
        cable_set: The cable set to make active; the choice of the cardsflow.xml if None.
        notes: Where findings, places and files go.

    Raises:
        InputError: A file is not readable XML, or is xacro.
        UnknownNameError: There is no such cable set.
    """
    root = parse(file, Subject("robot", file.stem), notes)
    _refuse_xacro(root)
    if root.tag != "robot":
        root.error("not-urdf", f"<{root.tag}> is not <robot>")
        return None
    node = root.about(Subject("robot", root.attribute("name")))
    for kind in ("link", "joint"):
        distinct(node.all(kind), partial(Subject, kind))
    elements = [child for child in node.all("link") if child.attribute("name", "") != WORLD]
    motors = motor_joints(node)
    joints = [read_joint(_about(child, "joint"), motors) for child in node.all("joint")]
    roots = welds(elements, joints, lambda _: IDENTITY, node)
    beside = cardsflow_xml(node)
    joints, inner = join_chains([*roots, *joints], beside)
    colors = material_colors(node)
    links = [read_link(_about(child, "link"), colors) for child in elements]
    links = [link for link in links if link.name not in inner]
    note_shapes(node)
    note_missing_meshes(node, links)
    ordered = parents_first(joints)
    robot = Robot(node.subject.name, tuple(links), tuple(ordered))
    robot = read_mujoco_tag(robot, node)
    robot = read_extras(robot, node, beside, cable_set)
    return _with_motors_by_effort(robot, node, motors, beside)


def _about(node: Node, kind: str) -> Node:
    return node.about(Subject(kind, node.attribute("name")))


def _refuse_xacro(root: Node) -> None:
    """Xacro is a program that writes URDF; its elements are no robot's."""
    spaces = map(str, root.element.nsmap.values())
    if root.file.suffix == ".xacro" or any(space.endswith("xacro") for space in spaces):
        if root.file.suffix != ".xacro" and not _has_macros(root):
            return
        name = root.file.name.removesuffix(".xacro").removesuffix(".urdf") + ".urdf"
        raise InputError(XACRO.format(root.file.name, name), file=root.file)


def _has_macros(root: Node) -> bool:
    return any("}" in str(element.tag) for element in root.element.iter())


def _with_motors_by_effort(
    robot: Robot, node: Node, motors: set[str], beside: Sequence[Node]
) -> Robot:
    """Return the robot with a motor at each joint with an effort limit if no file names motors."""
    if motors or robot.motors:
        return robot
    joints = tuple(_driven(joint) for joint in robot.joints)
    names = [c.name for joint in joints for c in joint.coordinates if c.actuated]
    if not names:
        return robot
    if beside:
        problem = (
            "cardsflow.xml specifies what drives the robot; joints with an effort limit have no "
            f"motor: {', '.join(map(repr, names[:10]))}; add a <transmission> for each motor"
        )
        node.warning("no-motors-by-effort", problem)
        return robot
    problem = (
        f"no <transmission>, <ros2_control> or cardsflow.xml specifies motors; the "
        f"{len(names)} joints with an effort limit are read as motor-driven"
    )
    node.warning("motors-by-effort", problem)
    return replace(robot, joints=joints)


def _driven(joint: Joint) -> Joint:
    coordinates = tuple(
        replace(c, actuated=c.is_free and 0.0 < c.tau_max < float("inf")) for c in joint.coordinates
    )
    return replace(joint, coordinates=coordinates)
