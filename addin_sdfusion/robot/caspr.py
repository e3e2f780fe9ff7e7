"""Writes a robot and its trajectories in CASPR's XML dialect.

CASPR numbers the links in the order of the joints and names neither joints nor coordinates. Its
link frames are the joint frames, all parallel at q = 0. Values stand exactly one space apart, and
the DOCTYPE lines stay: CASPR finds sets and trajectories through them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import accumulate, pairwise
from pathlib import Path
from xml.etree import ElementTree

from .caspr_joints import CASPR_AXIS_JOINTS, caspr_word
from .check import require_valid
from .errors import InputError
from .files import write_files
from .joint import Joint
from .model import GRAVITY, WORLD, Link, Robot, TaskFrame
from .muscle import Muscle
from .placement import IDENTITY
from .trajectory import Trajectory
from .xml_text import document, element, numbers

TEMPLATES = "../../../templates"
"""Where CASPR's models find its DTDs."""


def write_caspr(
    robot: Robot,
    folder: str | Path,
    name: str | None = None,
    trajectories: Sequence[Trajectory] = (),
) -> list[Path]:
    """Write `<name>_bodies.xml`, `_cables.xml`, `_operational_spaces.xml` and `_trajectories.xml`.

    Args:
        robot: What to write.
        folder: Where to; made if it does not exist.
        name: How the files begin; the robot's name if None.
        trajectories: Joint trajectories, in the order of the robot's coordinates.

    Returns:
        The files written.

    Raises:
        RobotError: The robot has errors.
        InputError: CASPR cannot hold the robot, or the folder cannot be written.
    """
    require_valid(robot)
    _require_caspr(robot)
    name = robot.name if name is None else name
    if not name or any(sign in name for sign in "/\\\0"):
        raise InputError(f"{name!r} cannot be part of a file name; give another name")
    texts = {
        f"{name}_bodies.xml": _bodies(robot),
        f"{name}_cables.xml": _cables(robot),
        f"{name}_operational_spaces.xml": _operational_spaces(robot),
        f"{name}_trajectories.xml": _trajectories(robot, trajectories),
    }
    return write_files(folder, texts)


def _require_caspr(robot: Robot) -> None:
    if robot.gravity != GRAVITY:
        raise InputError(f"CASPR's gravity is {GRAVITY}, not {robot.gravity}")
    for joint in robot.joints:
        if joint.type == "fixed":
            raise InputError(f"CASPR has no fixed joints: merge the links of {joint.name!r}")
        if caspr_word(joint.motions) is None:
            raise InputError(f"CASPR has no joint with the motions of {joint.name!r}")
        if any(joint.T_parent_joint.rpy) or any(joint.T_child_joint.rpy):
            what = f"CASPR has no turned frames: joint {joint.name!r} turns one at q = 0"
            raise InputError(what)
        if joint.T_child_joint != IDENTITY:
            what = f"in CASPR the frame of link {joint.child!r} is that of joint {joint.name!r}"
            raise InputError(f"{what}; move the link's frame there")
        if len({coordinate.actuated for coordinate in joint.coordinates}) > 1:
            raise InputError(f"in CASPR all coordinates of {joint.name!r} are actuated, or none")
        if any(coordinate.damping for coordinate in joint.coordinates):
            raise InputError(f"CASPR has no damping: joint {joint.name!r} has; set it to 0")


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
    word = caspr_word(joint.motions)
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
    node = element(cable_set, "cable_ideal", name=muscle.name, attachment_reference="joint")
    properties = element(node, "properties")
    element(properties, "force_min", muscle.f_min)
    element(properties, "force_max", muscle.f_max)
    attachments = element(node, "attachments")
    for point in muscle.via_points:
        attachment = element(attachments, "attachment")
        element(attachment, "link", str(numbered[point.link]))
        element(attachment, "location", numbers(point.position))


def _operational_spaces(robot: Robot) -> str:
    root = element(None, "operational_spaces", default_operational_set=robot.task_set)
    numbered = _numbers(robot)
    for task_set in robot.task_sets:
        node = element(root, "operational_set", id=task_set.name)
        for i, frame in enumerate(task_set.frames, start=1):
            _position(node, i, frame, numbered)
    # The name in the DOCTYPE is not that of the root in any of CASPR's own files either.
    return document(root, f'trajectories SYSTEM "{TEMPLATES}/operational_spaces.dtd"')


def _position(
    task_set: ElementTree.Element, i: int, frame: TaskFrame, numbered: dict[str, int]
) -> None:
    node = element(task_set, "position", marker_id=str(i), name=frame.name)
    element(node, "link", str(numbered[frame.link]))
    element(node, "offset", numbers(frame.position))
    element(node, "axes", active_axes="".join(frame.axes))


def _trajectories(robot: Robot, trajectories: Sequence[Trajectory]) -> str:
    root = element(None, "trajectories")
    group = element(root, "joint_trajectories")
    for trajectory in trajectories:
        _trajectory(group, trajectory, len(robot.coordinates))
    return document(root, f'trajectories SYSTEM "{TEMPLATES}/trajectories.dtd"')


def _trajectory(group: ElementTree.Element, trajectory: Trajectory, size: int) -> None:
    definition, times = _times(trajectory)
    node = element(
        group,
        f"{trajectory.spline}_spline_trajectory",
        id=trajectory.name,
        time_definition=definition,
        time_step=numbers([trajectory.time_step]),
    )
    points = element(node, "points")
    for i, (point, time) in enumerate(zip(trajectory.points, times, strict=True)):
        if len(point.q) != size:
            what = f"trajectory {trajectory.name!r} has {len(point.q)} values a point"
            raise InputError(f"{what}; the robot has {size} coordinates")
        attributes = {"time": numbers([time])} if i else {}
        item = element(points, "point", None, **attributes)
        for tag, values in (("q", point.q), ("q_dot", point.qd), ("q_ddot", point.qdd)):
            if values:
                element(item, tag, numbers(values))


def _times(trajectory: Trajectory) -> tuple[str, list[float]]:
    """Times as CASPR's models give them, from point to point, unless rounding would shift one."""
    times = [point.time for point in trajectory.points]
    steps = [0.0, *(end - start for start, end in pairwise(times))]
    return ("relative", steps) if list(accumulate(steps)) == times else ("absolute", times)


def _numbers(robot: Robot) -> dict[str, int]:
    """CASPR's numbers of the links; 0 is the base."""
    numbered = {joint.child: i for i, joint in enumerate(robot.joints, start=1)}
    return {WORLD: 0, **numbered}
