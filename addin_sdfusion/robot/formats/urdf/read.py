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
from ...model.function import Polynomial
from ...model.joint import Coordinate, Joint
from ...model.pose import IDENTITY
from ...model.robot import WORLD, Robot
from ..cardsflow.extras import cardsflow_xml, read_extras
from ..muscle_table.beside import table_of
from ..reading.chains import join_chains
from ..reading.meshes import note_missing_meshes
from ..reading.tree import fixed_roots, parents_first
from ..reading.unique_names import with_unique_names
from ..reading.xml import Node, Notes, parse
from .read_joints import read_joint
from .read_links import material_colors, note_shapes, read_link

COMMAND_INTERFACES = ("effort", "velocity", "position")
"""Command interfaces of ros2_control."""
BY_EFFORT = "motors-by-effort"
"""Code of the finding on motors that the file does not define."""
XACRO = (
    "is xacro, not URDF; convert it with `xacro {0} > {1}` (xacro is part of ROS; if it is "
    "missing, install it with `pip install xacro`)"
)


def read_urdf(file: Path, cable_set: str | None, notes: Notes) -> Robot | None:
    """Return the robot in a URDF file.

    Args:
        file: The URDF file.
        cable_set: Cable set to activate; the default of the cardsflow.xml if None.
        notes: Collects findings, locations and files.

    Raises:
        InputError: A file is not readable XML, or is xacro.
        UnknownNameError: The cable set does not exist.
    """
    root = parse(file, Subject("robot", file.stem), notes)
    _reject_xacro(root)
    if root.tag != "robot":
        root.error("not-urdf", f"<{root.tag}> is not <robot>")
        return None
    node = root.with_subject(Subject("robot", root.attribute("name")))
    for kind in ("link", "joint"):
        with_unique_names(node.all(kind), partial(Subject, kind))
    elements = [child for child in node.all("link") if child.attribute("name", "") != WORLD]
    motors = _motor_joints(node)
    joints = [read_joint(_about(child, "joint"), motors) for child in node.all("joint")]
    joints = _with_leading_friction(joints, node)
    roots = fixed_roots(elements, joints, lambda _: IDENTITY, node)
    extra_nodes = cardsflow_xml(node)
    joints, inner = join_chains([*roots, *joints], extra_nodes)
    colors = material_colors(node)
    links = [read_link(_about(child, "link"), colors) for child in elements]
    links = [link for link in links if link.name not in inner]
    note_shapes(node)
    note_missing_meshes(node, links)
    ordered = parents_first(joints)
    robot = Robot(node.subject.name, tuple(links), tuple(ordered))
    robot = _read_mujoco_tag(robot, node)
    robot = read_extras(robot, node, extra_nodes, cable_set)
    return _with_motors_by_effort(robot, node, motors, extra_nodes)


def _about(node: Node, kind: str) -> Node:
    return node.with_subject(Subject(kind, node.attribute("name")))


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
    joints = tuple(_with_motors(joint) for joint in robot.joints)
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


def _with_motors(joint: Joint) -> Joint:
    coordinates = tuple(
        replace(c, actuated=c.is_free and 0.0 < c.tau_max < float("inf")) for c in joint.coordinates
    )
    return replace(joint, coordinates=coordinates)


def _with_leading_friction(joints: Sequence[Joint], node: Node) -> list[Joint]:
    """Return the joints with the friction of following joints on their leading joints.

    The dissipated power is the same: friction f of a joint that moves k times as fast as its
    leading joint equals friction |k| f of the leading joint.

    Args:
        joints: The joints.
        node: Element for the finding.
    """
    known = {c.name: c for joint in joints for c in joint.coordinates}
    friction = dict.fromkeys(known, 0.0)
    moved = []
    for c in known.values():
        leader, ratio = _leader(c, known)
        friction[leader] += ratio * c.friction
        if leader != c.name and c.friction:
            moved.append(c.name)
    if not moved:
        return list(joints)
    names = ", ".join(map(repr, moved[:10]))
    problem = f"the friction of {names}, which follow others, is applied to the leading joints"
    node.warning("friction-of-mimic", problem)
    return [
        replace(
            joint,
            coordinates=tuple(replace(c, friction=friction[c.name]) for c in joint.coordinates),
        )
        for joint in joints
    ]


def _leader(coordinate: Coordinate, known: dict[str, Coordinate]) -> tuple[str, float]:
    """Return the coordinate that drives one, and the magnitude of the ratio of their velocities.

    A coordinate that follows an unknown one, or itself, is its own leader.
    """
    ratio, at = 1.0, coordinate
    for _ in known:
        if len(at.coupling) != 1:
            break
        (term,) = at.coupling
        if term.coordinate not in known or not isinstance(term.function, Polynomial):
            return coordinate.name, 1.0
        ratio *= abs(term.function.coefficients[1])
        at = known[term.coordinate]
    return (at.name, ratio) if not at.coupling else (coordinate.name, 1.0)


def _read_mujoco_tag(robot: Robot, node: Node) -> Robot:
    """Return the robot with the gravity of `<mujoco><option>`; report other settings as omitted."""
    for mujoco in node.all("mujoco"):
        for child in mujoco.all():
            words = set(map(str, child.element.attrib))
            if child.tag == "option" and child.has("gravity"):
                robot = replace(robot, gravity=child.vector_attribute("gravity"))
                words.discard("gravity")
            if words or child.tag not in ("option", "compiler"):
                listed = ", ".join(sorted(words)) or "all of it"
                problem = f"<{child.tag}> of <mujoco> is only for MuJoCo; omitted: {listed}"
                child.warning("element-left-out", problem)
    return robot


def _motor_joints(robot: Node) -> set[str]:
    """Return the names of the joints with a motor; report motors of unknown joints."""
    known = {joint.attribute("name", "") for joint in robot.all("joint")}
    named = [*_of_transmissions(robot), *_of_ros2(robot)]
    for node in named:
        if node.attribute("name") not in known:
            problem = f"<{node.tag}>: unknown joint {node.attribute('name', '')!r}"
            node.warning("unknown-joint", f"{problem}; its motor is omitted")
    return {name for node in named if (name := node.attribute("name", "")) in known}


def _of_transmissions(robot: Node) -> list[Node]:
    named = []
    for transmission in robot.all("transmission"):
        named += transmission.all("joint")
        for actuator in transmission.all("actuator"):
            ratio = actuator.number("mechanicalReduction", 1.0)
            if ratio != 1.0:
                problem = (
                    f"its reduction {ratio:g} is ignored; motor torques are joint torques here"
                )
                actuator.warning("reduction-left-out", problem)
    return named


def _of_ros2(robot: Node) -> list[Node]:
    return [
        joint
        for control in robot.all("ros2_control")
        for joint in control.all("joint")
        if any(
            c.attribute("name", "") in COMMAND_INTERFACES for c in joint.all("command_interface")
        )
    ]
