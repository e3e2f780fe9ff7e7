"""Writer of robots and trajectories in the XML format of CASPR.

CASPR numbers the links in the order of the joints and names neither joints nor coordinates. Its
link frames are the joint frames, all parallel at q = 0. Values must be separated by exactly one
space. The DOCTYPE lines are required: CASPR uses them to find sets and trajectories.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from ...caspr_vocabulary import CASPR_CABLES, CASPR_PULLEYS, Property, cable_tag
from ...checks.check import require_valid
from ...files import write_files
from ...model.joint import Joint
from ...model.muscle import BasePulley, Muscle, ViaPoint
from ...model.robot import WORLD, Link, Robot
from ...model.trajectory import Trajectory
from ..capability import require_writable
from ..writing.file_names import file_stem
from ..writing.plain_paths import with_plain_paths
from ..writing.xml_text import document, element, numbers
from .capabilities import caspr_losses
from .joints import CASPR_AXIS_JOINTS, caspr_joint_type
from .write_tasks import task_items
from .write_trajectories import traj_file, traj_text, write_trajectory

TEMPLATES = "../../../templates"
"""Path from a model of CASPR to its DTDs."""


def write_caspr(
    robot: Robot,
    folder: str | Path,
    name: str | None = None,
    trajectories: Sequence[Trajectory] = (),
) -> list[Path]:
    """Write `<name>_bodies.xml`, `_cables.xml`, `_operational_spaces.xml` and `_trajectories.xml`.

    Sampled trajectories are written to separate `<name>_<number>.traj` files. `caspr_losses` lists
    the features that CASPR cannot hold.

    Args:
        folder: Output folder; created if it does not exist.
        name: Prefix of the file names; the name of the robot if None.
        trajectories: Values in the order of the robot's coordinates or of an operational space.

    Raises:
        RobotError: The robot has errors, or CASPR cannot hold it.
        InputError: The folder cannot be written, or the name is not a valid file name.
    """
    require_valid(robot)
    require_writable(caspr_losses(robot, trajectories), "caspr")
    name = file_stem(robot.name if name is None else name)
    texts = {
        f"{name}_bodies.xml": _bodies(robot),
        f"{name}_cables.xml": _cables(with_plain_paths(robot)),
        f"{name}_operational_spaces.xml": _operational_spaces(robot),
        f"{name}_trajectories.xml": _trajectories(name, trajectories),
    }
    for i, trajectory in enumerate(trajectories, start=1):
        if trajectory.spline == "samples":
            texts[traj_file(name, i)] = traj_text(trajectory)
    return write_files(folder, texts)


def _bodies(robot: Robot) -> str:
    root = element(None, "bodies_system")
    reach = math.ceil(sum(math.hypot(*j.T_parent_joint.position) for j in robot.joints)) + 1.0
    range_ = numbers((-reach, reach) * 3)
    links = element(root, "links", display_range=range_, view_angle="0 0")
    numbered = _numbers(robot)
    for joint in robot.joints:
        _link(links, robot.link(joint.child), joint, numbered)
    return document(root, f'bodies_system SYSTEM "{TEMPLATES}/bodies.dtd"')


def _link(links: ElementTree.Element, link: Link, joint: Joint, numbered: dict[str, int]) -> None:
    node = element(links, "link_rigid", num=str(numbered[link.name]), name=link.name)
    element(node, "joint", **_joint_attributes(joint))
    physical = element(node, "physical")
    element(physical, "mass", link.inertia.mass)
    element(physical, "com_location", numbers(link.inertia.com))
    element(physical, "end_location", numbers(link.end or (0.0, 0.0, 0.0)))
    inertia = element(physical, "inertia", ref="com")
    for entry in ("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"):
        element(inertia, entry, getattr(link.inertia, entry.lower()))
    parent = element(node, "parent")
    element(parent, "num", str(numbered[joint.parent]))
    element(parent, "location", numbers(joint.T_parent_joint.position))


def _joint_attributes(joint: Joint) -> dict[str, str]:
    word = caspr_joint_type(joint.motions)
    assert word is not None
    axis = {"axis": numbers(joint.motions[0].axis)} if word in CASPR_AXIS_JOINTS else {}
    actuated = {"actuated": "true"} if any(q.actuated for q in joint.coordinates) else {}
    return {
        "type": word,
        **axis,
        "q_initial": numbers([q.initial for q in joint.coordinates]),
        "q_min": numbers([q.lower for q in joint.coordinates]),
        "q_max": numbers([q.upper for q in joint.coordinates]),
        **actuated,
    }


def _cables(robot: Robot) -> str:
    root = element(None, "cables", default_cable_set=robot.cable_set)
    numbered = _numbers(robot)
    for cable_set in robot.cable_sets:
        node = element(root, "cable_set", id=cable_set.name)
        for muscle in cable_set.muscles:
            _cable(node, muscle, numbered)
    return document(root, f'cables SYSTEM "{TEMPLATES}/cables.dtd"')


def _cable(cable_set: ElementTree.Element, muscle: Muscle, numbered: dict[str, int]) -> None:
    tag = cable_tag(muscle.model.kind)
    node = element(cable_set, tag, name=muscle.name, attachment_reference="joint")
    properties = element(node, "properties")
    if muscle.model.kind != "passive_spring":
        element(properties, "force_min", muscle.f_min)
        element(properties, "force_max", muscle.f_max)
    for item in CASPR_CABLES[tag].properties:
        _property(properties, item, dict(muscle.model.parameters))
    attachments = element(node, "attachments")
    for i, point in enumerate(muscle.via_points):
        if i == 0 and muscle.pulley is not None:
            _pulley(attachments, muscle.pulley, point)
            continue
        attachment = element(attachments, "attachment")
        element(attachment, "link", str(numbered[point.link]))
        element(attachment, "location", numbers(point.position))


def _property(parent: ElementTree.Element, item: Property, parameters: dict[str, float]) -> None:
    """Add a property of a cable if its parameters are set."""
    count = item.size or len(parameters)
    names = [item.name(k) for k in range(1, count + 1)]
    values = [parameters[name] for name in names if name in parameters]
    if values:
        element(parent, item.tag, numbers(values))


def _pulley(attachments: ElementTree.Element, pulley: BasePulley, point: ViaPoint) -> None:
    tag = next(tag for tag, words in CASPR_PULLEYS.items() if words.kind == pulley.kind)
    node = element(attachments, tag)
    element(node, CASPR_PULLEYS[tag].location, numbers(point.position))
    parameters = dict(pulley.parameters)
    for item in CASPR_PULLEYS[tag].properties:
        element(node, item.tag, numbers(parameters[item.tag]))


def _operational_spaces(robot: Robot) -> str:
    root = element(None, "operational_spaces", default_operational_set=robot.task_set)
    numbered = _numbers(robot)
    for task_set in robot.task_sets:
        node = element(root, "operational_set", id=task_set.name)
        for i, item in enumerate(task_items(task_set.frames), start=1):
            child = element(node, item.tag, marker_id=str(i), name=item.name)
            element(child, "link", str(numbered[item.link]))
            if item.offset is not None:
                element(child, "offset", numbers(item.offset))
            element(child, "axes", active_axes=item.letters)
    # The DOCTYPE name differs from the root element in all files of CASPR.
    return document(root, f'trajectories SYSTEM "{TEMPLATES}/operational_spaces.dtd"')


def _trajectories(name: str, trajectories: Sequence[Trajectory]) -> str:
    root = element(None, "trajectories")
    joint = element(root, "joint_trajectories")
    operational = None
    for i, trajectory in enumerate(trajectories, start=1):
        if trajectory.space == "operational" and operational is None:
            operational = element(root, "operational_trajectories")
        group = joint if trajectory.space == "joint" or operational is None else operational
        write_trajectory(group, trajectory, traj_file(name, i))
    return document(root, f'trajectories SYSTEM "{TEMPLATES}/trajectories.dtd"')


def _numbers(robot: Robot) -> dict[str, int]:
    """Return the numbers of the links in CASPR; 0 is the base."""
    numbered = {joint.child: i for i, joint in enumerate(robot.joints, start=1)}
    return {WORLD: 0, **numbered}
