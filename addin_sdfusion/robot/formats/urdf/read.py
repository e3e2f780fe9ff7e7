"""Reader of URDF files and the cardsflow.xml next to them.

URDF contains links, joints, limits, motors and meshes. Features that URDF does not support, such as
muscles, are read from a cardsflow.xml in the same folder, as written by `write_urdf`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from ...errors import InputError
from ...finding import Subject
from ...model.joint import Coordinate
from ...model.pose import IDENTITY
from ...model.robot import WORLD, Robot
from ..cardsflow.extras import cardsflow_xml, read_extras
from ..muscle_table.beside import table_of
from ..reading.chains import join_chains
from ..reading.meshes import note_missing_meshes
from ..reading.tree import fixed_roots, parents_first
from ..reading.unique_names import with_unique_names
from ..reading.xml import Node, Notes, parse
from .mimic_friction import with_leading_friction
from .mujoco_tag import read_mujoco_tag
from .read_joints import read_joint
from .read_links import material_colors, note_shapes, read_link
from .read_motors import motor_joints

BY_EFFORT = "motors-by-effort"
"""Code of the finding on motors that the file does not define."""
XACRO = (
    "is xacro, not URDF; convert it with `xacro {0} > {1}` (xacro is part of ROS; if it is "
    "missing, install it with `pip install xacro`)"
)


def read_urdf(file: Path, cable_set: str | None, notes: Notes) -> Robot | None:
    """Return the robot in a URDF file."""
    root = parse(file, Subject("robot", file.stem), notes)
    _reject_xacro(root)
    if root.tag != "robot":
        root.error("not-urdf", f"<{root.tag}> is not <robot>")
        return None
    node = root.named("robot")
    for kind in ("link", "joint"):
        with_unique_names(node.all(kind), partial(Subject, kind))
    elements = [child for child in node.all("link") if child.attribute("name", "") != WORLD]
    motors = motor_joints(node)
    joints = [read_joint(child.named("joint"), motors) for child in node.all("joint")]
    joints = with_leading_friction(joints, node)
    roots = fixed_roots(elements, joints, lambda _: IDENTITY, node)
    extra_nodes = cardsflow_xml(node)
    joints, inner = join_chains([*roots, *joints], extra_nodes)
    colors = material_colors(node)
    links = [read_link(child.named("link"), colors) for child in elements]
    links = [link for link in links if link.name not in inner]
    note_shapes(node)
    note_missing_meshes(node, links)
    ordered = parents_first(joints)
    robot = Robot(node.subject.name, tuple(links), tuple(ordered))
    robot = read_mujoco_tag(robot, node)
    robot = read_extras(robot, node, extra_nodes, cable_set)
    return _with_motors_by_effort(robot, node, motors, extra_nodes)


def _reject_xacro(root: Node) -> None:
    """Raise an error for a xacro file, which must first be converted to URDF."""
    spaces = map(str, root.element.nsmap.values())
    if root.file.suffix == ".xacro" or any(space.endswith("xacro") for space in spaces):
        if root.file.suffix != ".xacro" and not _has_macros(root):
            return
        name = root.file.name.removesuffix(".xacro").removesuffix(".urdf") + ".urdf"
        raise InputError(XACRO.format(root.file.name, name), file=root.file)


def _has_macros(root: Node) -> bool:
    return any("}" in str(element.tag) for element in root.element.iter())


def _with_motors_by_effort(
    robot: Robot, node: Node, motors: set[str], extra_nodes: Sequence[Node]
) -> Robot:
    """Return the robot with motors on all joints with an effort limit if no motors are defined."""
    if motors or robot.motors:
        return robot
    joints = tuple(joint.map_coordinates(_with_motor) for joint in robot.joints)
    names = [c.name for joint in joints for c in joint.coordinates if c.actuated]
    if not names:
        return robot
    table = table_of(node.file)
    if extra_nodes or table is not None:
        source = "cardsflow.xml" if table is None else table.name
        problem = (
            f"{source} specifies what drives the robot; joints with an effort limit have no "
            f"motor: {', '.join(map(repr, names[:10]))}; add a <transmission> for each motor"
        )
        node.warning("no-motors-by-effort", problem)
        return robot
    problem = (
        "no <transmission>, <ros2_control>, cardsflow.xml or muscles.csv defines drives; the "
        f"{len(names)} joints with an effort limit get motors"
    )
    node.warning(BY_EFFORT, problem)
    return replace(robot, joints=joints)


def _with_motor(c: Coordinate) -> Coordinate:
    return replace(c, actuated=c.is_free and 0.0 < c.tau_max < float("inf"))
