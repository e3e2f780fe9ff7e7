"""Writer of the plugin element, which contains all data that SDF does not support.

gravity: x y z, in [m/s²].
link_end link: far end of a link, in its frame, in [m].
mesh_name link role as: name of a mesh; `as` is the name in SDF.
joint name: its coordinates in the order of q, as coordinate elements. If functions, couplings or
    locks drive its motions, all motions in order, as motion elements.
coordinate name joint motion actuated torques initial spring armature unit locked: `joint` is the
    joint element that moves it. `motion` is the index of its motion from the parent to the child,
    counted from 0. `actuated` is whether it has a motor. Optional: `torques`, the motor limits, if
    they differ from the joint's effort; `initial`, if not 0 (the newest version of SDF has no
    <initial_position>); `spring`, stiffness and rest, in a cardsflow.xml next to a URDF;
    `armature`; `unit`, if it differs from the unit of the motion; `locked`. Its coupling is in
    term elements, its limit force in limit_force low high stiffness_low stiffness_high damping
    transition inertia (default: 0).
motion joint coordinate, term coordinate: contain a function, see `functions`.
loop_joint name type: a loop joint that the robot file cannot hold, with an axis element for each
    axis, and the elements parent link and child link with the poses of its frame, in [m, rad].
wrap_surface name link shape radius length half_axes: surface that muscles wrap over; its pose in
    the link frame, in [m, rad].
cable_set id active: myoMuscle elements as in cardsflow.xml, with wrap elements.
task_set id active: endEffector elements as in cardsflow.xml.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from xml.etree import ElementTree

from ...model.joint import Coordinate, Joint
from ...model.loop import LoopJoint
from ...model.muscle import WrapSurface
from ...model.robot import Link, Robot
from ..cardsflow.write import end_effector_element, muscle_element, wrap_elements
from ..writing.functions import function_element
from ..writing.xml_text import document, element, numbers
from .names import mesh_names
from .write_joints import has_one_effort, loops_in_plugin, needs_plugin, sdf_joints

PLUGIN = {"filename": "libcardsflow_gazebo_plugin.so", "name": "cardsflow_gazebo_plugin"}


def plugin_element(model: ElementTree.Element, robot: Robot) -> None:
    """Add the plugin element to a model."""
    node = element(model, "plugin", None, **PLUGIN)
    plugin_content(node, robot, _joint_elements(robot), loops=loops_in_plugin(robot))


def extras_text(robot: Robot) -> str:
    """Return the content of the plugin as a cardsflow.xml, for a model without a plugin."""
    root = element(None, "cardsflow")
    plugin_content(root, robot, _joint_elements(robot), loops=loops_in_plugin(robot))
    return document(root)


def _joint_elements(robot: Robot) -> dict[str, list[str]]:
    """Return the joint elements of the motions of each joint, in order."""
    written = sdf_joints(robot).items()
    return {name: [j.name for j in joints for _ in j.motions] for name, joints in written}


def plugin_content(
    plugin: ElementTree.Element,
    robot: Robot,
    joint_elements: Mapping[str, Sequence[str]],
    *,
    loops: Sequence[LoopJoint],
    springs: bool = False,
) -> None:
    """Add the content of the plugin.

    Args:
        joint_elements: Joint elements of the motions of each joint, in order.
        loops: The loop joints that the format does not support.
        springs: Whether to write springs, for formats whose joint elements do not support them.
    """
    element(plugin, "gravity", numbers(robot.gravity))
    for link in robot.links:
        _link(plugin, link)
    for joint in robot.joints:
        if needs_plugin(joint) or (
            springs and any(c.stiffness or c.rest for c in joint.coordinates)
        ):
            _joint(plugin, joint, joint_elements[joint.name], springs=springs)
    for loop in loops:
        _loop_joint(plugin, loop)
    for surface in robot.wrap_surfaces:
        _wrap_surface(plugin, surface)
    for cable_set in robot.cable_sets:
        node = element(plugin, "cable_set", **_member(cable_set.name, robot.cable_set))
        for muscle in cable_set.muscles:
            wrap_elements(muscle_element(node, muscle), muscle)
    for task_set in robot.task_sets:
        node = element(plugin, "task_set", **_member(task_set.name, robot.task_set))
        for frame in task_set.frames:
            end_effector_element(node, frame)


def _member(name: str, active: str) -> dict[str, str]:
    return {"id": name, "active": "true" if name == active else "false"}


def _link(plugin: ElementTree.Element, link: Link) -> None:
    if link.end is not None:
        element(plugin, "link_end", numbers(link.end), link=link.name)
    for mesh, name in zip(link.meshes, mesh_names(link), strict=True):
        if mesh.name != name:
            attributes = {"link": link.name, "role": mesh.role, "as": name}
            element(plugin, "mesh_name", mesh.name, **attributes)


def _joint(
    plugin: ElementTree.Element, joint: Joint, joint_elements: Sequence[str], *, springs: bool
) -> None:
    node = element(plugin, "joint", name=joint.name)
    for i, coordinate in enumerate(joint.coordinates):
        place = joint.main_motion(i)
        words = {"joint": joint_elements[place], "motion": str(place)}
        if springs and (coordinate.stiffness or coordinate.rest):
            words["spring"] = numbers([coordinate.stiffness, coordinate.rest])
        _coordinate(node, coordinate, words, joint.motions[place].unit)
    if joint.is_plain:
        return
    for joint_element, motion in zip(joint_elements, joint.motions, strict=True):
        words = {"joint": joint_element}
        if not motion.is_fixed:
            words["coordinate"] = joint.coordinates[motion.coordinate].name
        function_element(node, "motion", motion.function, **words)


def _coordinate(
    parent: ElementTree.Element, coordinate: Coordinate, words: dict[str, str], unit: str
) -> None:
    if coordinate.initial:
        words["initial"] = numbers([coordinate.initial])
    if not has_one_effort(coordinate):
        words["torques"] = numbers([coordinate.tau_min, coordinate.tau_max])
    if coordinate.armature:
        words["armature"] = numbers([coordinate.armature])
    if coordinate.unit != unit:
        words["unit"] = coordinate.unit
    if coordinate.locked:
        words["locked"] = "true"
    words["actuated"] = "true" if coordinate.actuated else "false"
    node = element(parent, "coordinate", name=coordinate.name, **words)
    for term in coordinate.coupling:
        function_element(node, "term", term.function, coordinate=term.coordinate)
    if coordinate.limit_force is not None:
        force = asdict(coordinate.limit_force)
        element(node, "limit_force", **{name: numbers([x]) for name, x in force.items()})


def _loop_joint(plugin: ElementTree.Element, loop: LoopJoint) -> None:
    node = element(plugin, "loop_joint", None, name=loop.name, type=loop.type)
    for axis in loop.axes:
        element(node, "axis", numbers(axis))
    ends = (loop.parent, loop.T_parent_joint), (loop.child, loop.T_child_joint)
    for tag, (link, pose) in zip(("parent", "child"), ends, strict=True):
        element(node, tag, numbers((*pose.position, *pose.rpy)), link=link)


def _wrap_surface(plugin: ElementTree.Element, surface: WrapSurface) -> None:
    words = {"name": surface.name, "link": surface.link, "shape": surface.shape}
    words["radius"] = numbers([surface.radius])
    if surface.length != math.inf:
        words["length"] = numbers([surface.length])
    if surface.half_axes is not None:
        words["half_axes"] = numbers(surface.half_axes)
    text = numbers((*surface.pose.position, *surface.pose.rpy))
    element(plugin, "wrap_surface", text, **words)
