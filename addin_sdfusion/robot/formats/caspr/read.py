"""Reader of CASPR files: bodies, cables and operational spaces."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path

from ...errors import UnknownNameError
from ...finding import Subject
from ...model.joint import Coordinate, Joint, Motion
from ...model.pose import Pose, Vector3
from ...model.robot import WORLD, Inertia, Link, Robot
from ...model.rotations import normalized
from ..reading.unique_names import with_unique_names
from ..reading.xml import Node, Notes, parse, short_repr
from .joints import CASPR_AXIS_JOINTS, CASPR_JOINTS, CasprJoint
from .read_cables import read_cables
from .read_tasks import read_operational_spaces

BODIES = "_bodies.xml"


def read_caspr(bodies: Path, cable_set: str | None, notes: Notes) -> Robot | None:
    """Return the robot in a `<name>_bodies.xml` and the files next to it.

    CASPR does not name joints and coordinates; they are called `joint_1`, `joint_2`, ... by the
    number of their link. Link frames are joint frames.
    """
    name = bodies.name.removesuffix(BODIES)
    subject = Subject("robot", name)
    root = parse(bodies, subject, notes).with_subject(subject)
    group = _links_group(root)
    if group is None:
        return None
    links, joints = _links_and_joints(group)
    robot = Robot(name, tuple(links), tuple(joints))
    robot = _with_cables(robot, bodies.with_name(f"{name}_cables.xml"), cable_set, notes)
    file = bodies.with_name(f"{name}_operational_spaces.xml")
    return _with_tasks(robot, root.optional("operational_spaces"), file, notes)


def _with_cables(robot: Robot, file: Path, cable_set: str | None, notes: Notes) -> Robot:
    if not file.exists():
        if cable_set is not None:
            raise UnknownNameError("cable set", cable_set, [], file=file)
        return robot
    root = parse(file, Subject("robot", robot.name), notes)
    cable_sets, active = read_cables(root, robot.links, cable_set)
    return replace(robot, cable_sets=cable_sets, cable_set=active)


def _with_tasks(robot: Robot, old: Node | None, file: Path, notes: Notes) -> Robot:
    """Return the robot with its operational spaces."""
    if file.exists():
        if old is not None:
            problem = f"ignored, because {file.name} exists; remove this block"
            old.warning("old-operational-spaces", f"<operational_spaces> here: {problem}")
        root = parse(file, Subject("robot", robot.name), notes)
    elif old is not None:
        problem = f"read, but CASPR expects them in {file.name}; move the block there"
        old.warning("old-operational-spaces", f"<operational_spaces> here: {problem}")
        root = old
    else:
        return robot
    task_sets, active = read_operational_spaces(root, robot.links)
    return replace(robot, task_sets=task_sets, task_set=active)


def _links_group(root: Node) -> Node | None:
    """Return the element that contains the links: the root in older files."""
    if root.tag == "links":
        problem = "<links> is the root, as in older files; CASPR expects it in <bodies_system>"
        root.warning("old-bodies", f"{problem}; move it there")
        return root
    if root.tag != "bodies_system":
        root.error("not-caspr", f"<{root.tag}> is not CASPR's <bodies_system>")
        return None
    return root.required("links")


def _links_and_joints(group: Node) -> tuple[list[Link], list[Joint]]:
    links: list[Link] = []
    joints: list[Joint] = []
    nodes = with_unique_names(group.all(), partial(Subject, "link"))
    for i, node in enumerate(nodes, start=1):
        if node.tag != "link_rigid":
            node.error("unexpected-element", f"<{node.tag}> in <links>; CASPR expects <link_rigid>")
        node = node.named("link")
        if node.attribute("num") != str(i):
            problem = f"num {short_repr(node.attribute('num'))} must be {i}"
            node.error("wrong-number", f"{problem}; number the links 1, 2, ... in order")
        links.append(_link(node))
        joints.append(_joint(node, i, links))
    return links, joints


def _link(node: Node) -> Link:
    physical = node.required("physical")
    if physical is None:
        return Link(node.subject.name, Inertia(0.0))
    com = physical.vector("com_location")
    end_node = physical.optional("end_location")
    end = None if end_node is None else end_node.vector3()
    return Link(node.subject.name, _inertia(physical, physical.number("mass"), com), end)


def _inertia(physical: Node, mass: float, com: Vector3) -> Inertia:
    node = physical.required("inertia")
    if node is None:
        return Inertia(mass, com)
    entries = (node.number(f"I{tag}") for tag in ("xx", "yy", "zz", "xy", "xz", "yz"))
    inertia = Inertia(mass, com, *entries)
    reference = node.attribute("ref")
    if reference == "joint":
        return Inertia.of_origin(mass, com, inertia.matrix)
    if reference != "com":
        node.error("bad-reference", f"ref {short_repr(reference)} must be 'com' or 'joint'")
    return inertia


def _joint(link: Node, number: int, links: list[Link]) -> Joint:
    """Return the joint whose child is the last of the links."""
    name = f"joint_{number}"
    parent, location = _parent(link, number, links)
    T_parent_joint = Pose(location)
    node = link.required("joint")
    child = link.subject.name
    if node is None:
        return Joint(name, parent, child, T_parent_joint=T_parent_joint)
    node = node.with_subject(Subject("joint", name))
    motions, suffixes = _motions(node)
    coordinates = _coordinates(node, name, motions, suffixes)
    return Joint(name, parent, child, motions, coordinates, T_parent_joint)


def _motions(node: Node) -> CasprJoint:
    word = node.attribute("type")
    if word in CASPR_JOINTS:
        return CASPR_JOINTS[word]
    if word in CASPR_AXIS_JOINTS:
        axis = normalized(node.vector_attribute("axis"))
        return CasprJoint((Motion(CASPR_AXIS_JOINTS[word], axis),), ("",))
    problem = f"unsupported joint type {short_repr(word)}"
    node.error("unsupported-joint", problem, (*CASPR_JOINTS, *CASPR_AXIS_JOINTS))
    return CASPR_JOINTS["R_X"]


def _coordinates(
    node: Node, joint: str, motions: tuple[Motion, ...], suffixes: tuple[str, ...]
) -> tuple[Coordinate, ...]:
    """Return the coordinates of the joint, in the order of q in CASPR."""
    actuated = node.attribute("actuated", "false").lower() == "true"
    units = [motion.unit for motion in sorted(motions, key=lambda motion: motion.coordinate)]
    start = node.numbers_attribute("q_initial", len(units), infinite=True)
    columns = *_limits(node, len(units)), start
    coordinates = []
    for unit, suffix, lower, upper, initial in zip(units, suffixes, *columns, strict=True):
        name = f"{joint}_{suffix}" if suffix else joint
        node.with_subject(Subject("coordinate", name))
        coordinates.append(Coordinate(name, lower, upper, initial, unit=unit, actuated=actuated))
    return tuple(coordinates)


def _limits(node: Node, size: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the lower and upper limits of the joint, which older files do not contain."""
    missing = [word for word in ("q_min", "q_max") if not node.has(word)]
    if missing:
        problem = "read as unlimited, as in older files; CASPR requires both"
        node.warning("no-limits", f"<joint> has no {' and no '.join(missing)}: {problem}")
    limits = {
        word: (none,) * size
        if word in missing
        else node.numbers_attribute(word, size, infinite=True)
        for word, none in (("q_min", -inf), ("q_max", inf))
    }
    return limits["q_min"], limits["q_max"]


def _parent(link: Node, number: int, links: list[Link]) -> tuple[str, Vector3]:
    node = link.required("parent")
    if node is None:
        return WORLD, (0.0, 0.0, 0.0)
    location = node.vector("location")
    parent = node.integer("num")
    if parent is None or parent == 0:
        return WORLD, location
    if parent >= number:
        problem = f"parent {parent} must be a link before link {number}"
        node.error("unknown-parent", f"{problem}; move it before and renumber the links")
        return WORLD, location
    return links[parent - 1].name, location
