"""Reader of CASPR files: bodies, cables and operational spaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path

from ...caspr_vocabulary import CASPR_AXES, CASPR_TASKS, ORIENTATION
from ...errors import UnknownNameError
from ...finding import Subject, member
from ...model.joint import Coordinate, Joint, Motion
from ...model.pose import Pose, Vector3
from ...model.robot import WORLD, Axis, Inertia, Link, Robot, TaskFrame, TaskSet
from ...model.rotations import normalized, point_inertia
from ..reading.unique_names import with_unique_names
from ..reading.xml import ZERO, Node, Notes, parse, short_repr
from .joints import CASPR_AXIS_JOINTS, CASPR_JOINTS, CasprJoint
from .read_cables import read_cables
from .read_links import link_by_number

BODIES = "_bodies.xml"


def read_caspr(bodies: Path, cable_set: str | None, notes: Notes) -> Robot | None:
    """Return the robot in a `<name>_bodies.xml` and the files next to it.

    CASPR does not name joints and coordinates; they are called `joint_1`, `joint_2`, ... by the
    number of their link. Link frames are joint frames.

    Args:
        bodies: The bodies file.
        cable_set: Cable set to activate; the default of the file if None.
        notes: Collects findings, locations and files.

    Raises:
        InputError: A file is not readable XML.
        UnknownNameError: The cable set does not exist.
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
    task_sets, active = _read_operational_spaces(root, robot.links)
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
        node = node.with_subject(Subject("link", node.attribute("name")))
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
    entries = {tag: node.number(f"I{tag}") for tag in ("xx", "yy", "zz", "xy", "xz", "yz")}
    reference = node.attribute("ref")
    if reference == "joint":
        rows = point_inertia(mass, com)
        shift = {a + b: rows[i][j] for i, a in enumerate("xyz") for j, b in enumerate("xyz")}
        entries = {tag: value - shift[tag] for tag, value in entries.items()}
    elif reference != "com":
        node.error("bad-reference", f"ref {short_repr(reference)} must be 'com' or 'joint'")
    return Inertia(mass, com, **{f"i{tag}": value for tag, value in entries.items()})


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
    known = ", ".join([*CASPR_JOINTS, *CASPR_AXIS_JOINTS])
    node.error("unsupported-joint", f"unsupported joint type {short_repr(word)}; known: {known}")
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
    found = {
        word: (none,) * size
        if word in missing
        else node.numbers_attribute(word, size, infinite=True)
        for word, none in (("q_min", -inf), ("q_max", inf))
    }
    return found["q_min"], found["q_max"]


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


def _read_operational_spaces(root: Node, links: Sequence[Link]) -> tuple[tuple[TaskSet, ...], str]:
    """Return the task sets of a file and the name of the active set.

    Orientations are read with the convention of task frames. The convention of CASPR is not
    consistent: its y contains angles, but its Jacobian returns the angular velocity. The order of
    the angles also differs between poses and orientations.

    A pose becomes two task frames: a position with its name, and an orientation with the name plus
    `_orientation`.
    """
    if root.tag != "operational_spaces":
        root.error("not-caspr", f"<{root.tag}> is not CASPR's <operational_spaces>")
        return (), ""
    nodes = [
        node.with_subject(Subject("task_set", node.attribute("id")))
        for node in root.all("operational_set")
    ]
    nodes = [node for node in nodes if _has_items(node)]
    active = _active(root, [node.subject.name for node in nodes])
    return tuple(_task_set(node, links, active) for node in nodes), active


def _has_items(node: Node) -> bool:
    for item in node.all():
        if item.tag not in CASPR_TASKS:
            known = ", ".join(CASPR_TASKS)
            item.warning("unsupported-task", f"unknown <{item.tag}>; ignored (known: {known})")
    items = node.all(*CASPR_TASKS)
    if not items:
        problem = f"contains no {', '.join(CASPR_TASKS)}; the whole set is ignored"
        node.warning("empty-task-set", problem)
    return bool(items)


def _active(root: Node, names: list[str]) -> str:
    default = root.attribute("default_operational_set", "")
    if default and default not in names:
        what = UnknownNameError("operational space", default, names).what
        root.error("unknown-task-set", f"default_operational_set: {what}")
    return default or (names[0] if names else "")


def _task_set(node: Node, links: Sequence[Link], active: str) -> TaskSet:
    name = node.subject.name
    frames: list[TaskFrame] = []
    items = node.all(*CASPR_TASKS)
    for item in with_unique_names(items, partial(member, "task_frame", of=name, active=active)):
        subject = member("task_frame", item.attribute("name"), name, active)
        for frame in _task_frames(item.with_subject(subject), links):
            item.with_subject(member("task_frame", frame.name, name, active))
            frames.append(frame)
    return TaskSet(name, tuple(frames))


def _task_frames(node: Node, links: Sequence[Link]) -> list[TaskFrame]:
    """Return the frame of an item; a pose has a frame for its position and its orientation."""
    name = node.attribute("name")
    number = link_by_number(node, links)
    link = WORLD if number is None else number.name
    offset = ZERO if node.tag == "orientation_euler_xyz" else node.vector("offset")
    axes = _axes(node)
    lengths = tuple(axis for axis in axes if axis in ("x", "y", "z"))
    angles = tuple(axis for axis in axes if axis not in lengths)
    if not angles:
        return [TaskFrame(name, link, offset, lengths)]
    if not lengths:
        return [TaskFrame(name, link, ZERO, angles)]
    problem = "its angles are read as R = Rx Ry Rz, as in orientations; CASPR's poses differ"
    node.warning("pose-angles", problem)
    if axes != lengths + angles:
        node.warning("task-order", "the position coordinates come before the angles in y")
    point = TaskFrame(name, link, offset, lengths)
    return [point, TaskFrame(name + ORIENTATION, link, ZERO, angles)]


def _axes(node: Node) -> tuple[Axis, ...]:
    axes = node.required("axes")
    letters = axes.attribute("active_axes") if axes else ""
    allowed = CASPR_TASKS[node.tag]
    if axes and not set(letters) <= set(allowed):
        problem = f"active_axes {short_repr(letters)}: use only {', '.join(allowed)}, each once"
        axes.error("bad-task-axes", problem)
    return tuple(CASPR_AXES[letter] for letter in letters if letter in allowed)
