"""Writes a robot as an SDF 1.7 model folder.

Links and joints are placed so that both poses of a joint read back exactly: a joint relative to its
parent link, a link relative to the joint that carries it. Cable sets, task sets and what else SDF
has no word for stand in the plugin element:

    gravity                       x y z, in [m/s²]
    link_end    link              far end of a link, in its frame, in [m]
    cable_set   id active         myoMuscle elements as in cardsflow.xml
    task_set    id active         endEffector elements as in cardsflow.xml
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

from .cardsflow_xml import cardsflow_xml, end_effector_element, muscle_element
from .check import require_valid
from .errors import InputError
from .files import write_files
from .joint import Joint
from .model import WORLD, Link, Robot
from .placement import Pose
from .pose import inverse
from .xml_text import document, element, numbers

MODEL_FRAME = "__model__"
PLUGIN = {"filename": "libcardsflow_gazebo_plugin.so", "name": "cardsflow_gazebo_plugin"}
NO_LIMIT = 1e16
"""SDF's own value for a limit that is none, in [rad] or [m]."""


def write_sdf(robot: Robot, folder: str | Path) -> list[Path]:
    """Write model.sdf, model.config and cardsflow.xml.

    Args:
        robot: What to write.
        folder: Where to; made if it does not exist.

    Returns:
        The files written.

    Raises:
        RobotError: The robot has errors.
        InputError: SDF cannot hold the robot, or the folder cannot be written.
    """
    require_valid(robot)
    _require_sdf_names(robot)
    _require_single_motions(robot)
    _require_own_coordinate_names(robot)
    texts = {
        "model.sdf": _model_sdf(robot),
        "model.config": _model_config(robot),
        "cardsflow.xml": cardsflow_xml(robot),
    }
    return write_files(folder, texts)


def joint_frame_name(joint: str, child: str) -> str:
    """The name of the frame that keeps a rotated T_child_joint exactly."""
    return f"{joint}_in_{child}"


def _model_sdf(robot: Robot) -> str:
    root = element(None, "sdf", version="1.7")
    model = element(root, "model", name=robot.name)
    carriers = {joint.child: joint for joint in robot.joints}
    for link in robot.links:
        _link(model, link, carriers[link.name])
    for joint in robot.joints:
        _joint(model, joint)
    _plugin(model, robot)
    return document(root)


def _link(model: ElementTree.Element, link: Link, carrier: Joint) -> None:
    node = element(model, "link", name=link.name)
    _pose(node, inverse(carrier.T_child_joint), carrier.name)
    inertial = element(node, "inertial")
    _pose(inertial, Pose(link.inertia.com))
    element(inertial, "mass", link.inertia.mass)
    inertia = element(inertial, "inertia")
    for entry in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
        element(inertia, entry, getattr(link.inertia, entry))


def _joint(model: ElementTree.Element, joint: Joint) -> None:
    node = element(model, "joint", name=joint.name, type=joint.type)
    _pose(node, joint.T_parent_joint, MODEL_FRAME if joint.parent == WORLD else joint.parent)
    element(node, "parent", joint.parent)
    element(node, "child", joint.child)
    for coordinate, motion in zip(joint.coordinates, joint.motions, strict=True):
        axis = element(node, "axis")
        element(axis, "xyz", numbers(motion.axis))
        limit = element(axis, "limit")
        element(limit, "lower", max(coordinate.lower, -NO_LIMIT))
        element(limit, "upper", min(coordinate.upper, NO_LIMIT))
        element(element(axis, "dynamics"), "damping", coordinate.damping)
        element(axis, "initial_position", coordinate.initial)
    if _needs_frame(joint):
        frame = element(
            model, "frame", name=joint_frame_name(joint.name, joint.child), attached_to=joint.child
        )
        _pose(frame, joint.T_child_joint)


def _plugin(model: ElementTree.Element, robot: Robot) -> None:
    plugin = element(model, "plugin", None, **PLUGIN)
    element(plugin, "gravity", numbers(robot.gravity))
    for link in robot.links:
        if link.end is not None:
            element(plugin, "link_end", numbers(link.end), link=link.name)
    for cable_set in robot.cable_sets:
        node = element(plugin, "cable_set", **_member(cable_set.name, robot.cable_set))
        for muscle in cable_set.muscles:
            muscle_element(node, muscle)
    for task_set in robot.task_sets:
        node = element(plugin, "task_set", **_member(task_set.name, robot.task_set))
        for frame in task_set.frames:
            end_effector_element(node, frame)


def _member(name: str, active: str) -> dict[str, str]:
    return {"id": name, "active": "true" if name == active else "false"}


def _pose(parent: ElementTree.Element, pose: Pose, relative_to: str | None = None) -> None:
    attributes = {} if relative_to is None else {"relative_to": relative_to}
    element(parent, "pose", numbers((*pose.position, *pose.rpy)), **attributes)


def _needs_frame(joint: Joint) -> bool:
    """Whether the inverse of T_child_joint does not give it back bit by bit."""
    return inverse(inverse(joint.T_child_joint)) != joint.T_child_joint


def _model_config(robot: Robot) -> str:
    root = element(None, "model")
    element(root, "name", robot.name)
    element(root, "version", "1.0")
    element(root, "sdf", "model.sdf", version="1.7")
    element(element(root, "author"), "name", "")
    element(root, "description", "A musculoskeletal robot, written by CARDSFlow.")
    return document(root)


def _require_sdf_names(robot: Robot) -> None:
    """SDF keeps the names of links, joints and frames in one drawer and reserves some."""
    names = [link.name for link in robot.links] + [joint.name for joint in robot.joints]
    names += [joint_frame_name(j.name, j.child) for j in robot.joints if _needs_frame(j)]
    for name, count in Counter(names).items():
        if count > 1:
            what = f"SDF needs different names for links and joints; rename one of the {name!r}"
            raise InputError(what)
        if "::" in name or (name.startswith("__") and name.endswith("__")) or name == WORLD:
            raise InputError(f"SDF reserves the name {name!r}; rename the link or joint")


def _require_single_motions(robot: Robot) -> None:
    for joint in robot.joints:
        if len(joint.motions) > 1:
            what = f"joint {joint.name!r} ({joint.type}) has {len(joint.motions)} motions"
            raise InputError(f"{what}; SDF with muscles is written for single ones")


def _require_own_coordinate_names(robot: Robot) -> None:
    """An SDF axis has no name of its own."""
    for joint in robot.joints:
        for coordinate in joint.coordinates:
            if coordinate.name != joint.name:
                what = (
                    f"SDF has no names for coordinates; give coordinate {coordinate.name!r} "
                    f"the name of its joint, {joint.name!r}"
                )
                raise InputError(what)
