"""Writer of the model's plugin element, for all that SDF has no element for.

gravity: x y z, in [m/s²].
link_end link: the far end of a link, in its frame, in [m].
mesh_name link role as: the name of a mesh, in place of the one that it is written as.
joint name: its coordinates in the order of q, as coordinate elements, and where functions,
    couplings or locks drive its motions, all of these in their order as motion elements.
coordinate name joint motion actuated torques initial spring armature unit locked: the joint element
    that moves it, its place among the motions from the parent to the child, counted from 0, whether
    it has a motor, the bounds of its torque if they are not those of the joint's effort, its
    initial value if that is not 0 (SDF's <initial_position> is gone from its newest version),
    in a cardsflow.xml next to a URDF its spring's stiffness and rest, its armature if there is
    one, its unit if it is not the motion's, and whether it is held. Inside: its coupling as term
    elements; limit_force low high stiffness_low stiffness_high damping transition.
motion joint coordinate, term coordinate: with a function, see `functions`.
wrap_surface name link shape radius length half_axes: what muscles wrap over; its pose in the
    link's frame, in [m, rad].
cable_set id active: myoMuscle elements as in cardsflow.xml, with wrap elements.
task_set id active: endEffector elements as in cardsflow.xml.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from xml.etree import ElementTree

from ...model.joint import Coordinate, Joint
from ...model.muscle import WrapSurface
from ...model.robot import Link, Robot
from ..cardsflow.write import end_effector_element, muscle_element, wrap_elements
from ..writing.functions import function_element
from ..writing.xml_text import document, element, numbers
from .names import mesh_names
from .write_joints import has_one_effort, needs_words, sdf_joints

PLUGIN = {"filename": "libcardsflow_gazebo_plugin.so", "name": "cardsflow_gazebo_plugin"}


def plugin_element(model: ElementTree.Element, robot: Robot) -> None:
    """Add the plugin to a model."""
    plugin_content(element(model, "plugin", None, **PLUGIN), robot, _movers(robot))


def content_beside(robot: Robot) -> str:
    """What the plugin holds as the text of a cardsflow.xml, for a model without plugin."""
    root = element(None, "cardsflow")
    plugin_content(root, robot, _movers(robot))
    return document(root)


def _movers(robot: Robot) -> dict[str, list[str]]:
    """The names of the joint elements that make the motions of each joint, in their order."""
    written = sdf_joints(robot).items()
    return {name: [part.name for part in parts for _ in part.motions] for name, parts in written}


def plugin_content(
    plugin: ElementTree.Element,
    robot: Robot,
    movers: Mapping[str, Sequence[str]],
    *,
    springs: bool = False,
) -> None:
    """Add what the plugin holds.

    Args:
        plugin: Where to.
        robot: The robot.
        movers: The joint elements that make the motions of each joint, in their order.
        springs: Whether the joint elements have no words for springs.
    """
    element(plugin, "gravity", numbers(robot.gravity))
    for link in robot.links:
        _link(plugin, link)
    for joint in robot.joints:
        if needs_words(joint) or (
            springs and any(c.stiffness or c.rest for c in joint.coordinates)
        ):
            _joint(plugin, joint, movers[joint.name], springs=springs)
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
    plugin: ElementTree.Element, joint: Joint, movers: Sequence[str], *, springs: bool
) -> None:
    node = element(plugin, "joint", name=joint.name)
    for i, coordinate in enumerate(joint.coordinates):
        place = joint.home(i)
        words = {"joint": movers[place], "motion": str(place)}
        if springs and (coordinate.stiffness or coordinate.rest):
            words["spring"] = numbers([coordinate.stiffness, coordinate.rest])
        _coordinate(node, coordinate, words, joint.motions[place].unit)
    if joint.is_plain:
        return
    for mover, motion in zip(movers, joint.motions, strict=True):
        words = {"joint": mover}
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
        given = asdict(coordinate.limit_force)
        element(node, "limit_force", **{name: numbers([x]) for name, x in given.items()})


def _wrap_surface(plugin: ElementTree.Element, surface: WrapSurface) -> None:
    words = {"name": surface.name, "link": surface.link, "shape": surface.shape}
    words["radius"] = numbers([surface.radius])
    if surface.length != math.inf:
        words["length"] = numbers([surface.length])
    if surface.half_axes is not None:
        words["half_axes"] = numbers(surface.half_axes)
    text = numbers((*surface.pose.position, *surface.pose.rpy))
    element(plugin, "wrap_surface", text, **words)
