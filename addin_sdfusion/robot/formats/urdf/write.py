"""Writer of URDF: links, inertias, joints, limits, damping, motors, meshes.

Features that URDF does not support, such as muscles, are written to a cardsflow.xml next to it.
It has the same content as the plugin in SDF. Both files together restore the robot.

The root link is called `world`. A moving joint has the name of its coordinate, so that ROS joint
states by name match q by name; URDF does not define an order of joints. A joint with several
motions becomes a chain, see `joint_chains`. The frame of a URDF link is the frame of its parent
joint. A link with another frame is written in the joint frame, with its inertia and meshes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

from ...checks.check import require_valid
from ...files import write_files
from ...model.coupling import all_values
from ...model.function import Polynomial, derivatives
from ...model.joint import Coordinate
from ...model.pose import Pose
from ...model.robot import WORLD, Inertia, Link, Mesh, Robot, Shape
from ...model.rotations import normalized
from ...transforms.joint_chains import SingleJoint, single_joints
from ...transforms.simplify import joint_frames
from ..sdf.plugin import plugin_content
from ..sdf.write_joints import needs_plugin
from ..writing.file_names import file_name
from ..writing.xml_text import document, element, numbers
from .capabilities import IN_CARDSFLOW_XML, NO_LIMIT, leader_of


def write_urdf(robot: Robot, folder: str | Path, name: str | None = None) -> list[Path]:
    """Write `<name>.urdf`, and a cardsflow.xml if URDF cannot hold all features.

    Raises as `write_document`; the URDF is the first file returned.
    """
    require_valid(robot)
    framed = joint_frames(robot)
    files = {file_name(robot.name if name is None else name, "urdf"): urdf_text(robot)}
    if _needs_more(framed):
        files["cardsflow.xml"] = _extras_text(framed)
    return write_files(folder, files)


def urdf_text(robot: Robot) -> str:
    """Return the URDF text of a valid robot, without the content of the cardsflow.xml."""
    return _urdf(joint_frames(robot))


def _needs_more(robot: Robot) -> bool:
    """Return whether the robot has features that URDF does not support."""
    beyond = any(True for feature in IN_CARDSFLOW_XML for _ in feature.find(robot))
    return beyond or any(
        needs_plugin(joint) or any(c.rest for c in joint.coordinates) for joint in robot.joints
    )


def _extras_text(robot: Robot) -> str:
    """Return the text of the cardsflow.xml."""
    root = element(None, "cardsflow")
    singles = iter(single_joints(robot, keep_functions=True))
    joint_elements = {
        joint.name: [next(singles).name for _ in range(max(1, len(joint.motions)))]
        for joint in robot.joints
    }
    plugin_content(root, robot, joint_elements, loops=robot.loops, springs=True)
    return document(root)


def _urdf(robot: Robot) -> str:
    root = element(None, "robot", name=robot.name)
    element(root, "link", name=WORLD)
    singles = single_joints(robot, keep_functions=True)
    starts = all_values(robot, {c.name: c.initial for c in robot.coordinates})
    links = {link.name for link in robot.links}
    for link in robot.links:
        _link(root, link)
    for single in singles:
        if single.child not in links:
            _inertial(element(root, "link", name=single.child), Inertia(0.0))
    for single in singles:
        _joint(root, single, starts)
    for c in robot.motors:
        _transmission(root, c)
    return document(root)


def _transmission(root: ElementTree.Element, c: Coordinate) -> None:
    """Add the motor of a coordinate as a transmission of ROS."""
    node = element(root, "transmission", name=f"{c.name}_transmission")
    element(node, "type", "transmission_interface/SimpleTransmission")
    joint = element(node, "joint", name=c.name)
    element(joint, "hardwareInterface", "hardware_interface/EffortJointInterface")
    motor = element(node, "actuator", name=f"{c.name}_motor")
    element(motor, "mechanicalReduction", 1.0)


def _link(root: ElementTree.Element, link: Link) -> None:
    node = element(root, "link", name=link.name)
    _inertial(node, link.inertia)
    for mesh in link.meshes:
        _mesh(node, mesh)
    for shape in link.shapes:
        _shape(node, shape)


def _inertial(link: ElementTree.Element, inertia: Inertia) -> None:
    """Add the inertia of a link, also if it is zero: without it DART uses 1 kg."""
    node = element(link, "inertial")
    _origin(node, Pose(inertia.com))
    element(node, "mass", value=numbers([inertia.mass]))
    (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = inertia.matrix
    entries = {"ixx": ixx, "ixy": ixy, "ixz": ixz, "iyy": iyy, "iyz": iyz, "izz": izz}
    element(node, "inertia", None, **{entry: numbers([x]) for entry, x in entries.items()})


def _mesh(link: ElementTree.Element, mesh: Mesh) -> None:
    node = element(link, mesh.role, **({"name": mesh.name} if mesh.name else {}))
    _origin(node, mesh.pose)
    element(element(node, "geometry"), "mesh", filename=mesh.uri, scale=numbers(mesh.scale))
    if mesh.color is not None:
        name = f"{link.get('name')} {len(link)}"
        material = element(node, "material", name=name)
        element(material, "color", rgba=numbers(mesh.color))


def _shape(link: ElementTree.Element, shape: Shape) -> None:
    node = element(link, "collision")
    _origin(node, shape.pose)
    sizes = {"size": numbers(shape.sizes)}
    if shape.kind != "box":
        sizes = {n: numbers([s]) for n, s in zip(("radius", "length"), shape.sizes, strict=False)}
    element(element(node, "geometry"), shape.kind, None, **sizes)


def _joint(root: ElementTree.Element, single: SingleJoint, starts: Mapping[str, float]) -> None:
    node = element(root, "joint", name=single.name, type=_type(single))
    _origin(node, single.T_parent_joint)
    element(node, "parent", link=single.parent)
    element(node, "child", link=single.child)
    if single.motion is None or single.coordinate is None:
        return
    c = _coordinate_to_write(single.name, single.coordinate)
    element(node, "axis", xyz=numbers(normalized(single.motion.axis)))
    leader, function = leader_of(single)
    if function is not None:
        at = starts[leader]
        f, slope, _ = derivatives(function, at)
        line = function.coefficients if isinstance(function, Polynomial) else ()
        offset, slope = (*line, 0.0)[:2] if 0 < len(line) <= 2 else (f - slope * at, slope)
        words = {"multiplier": numbers([slope]), "offset": numbers([offset])}
        element(node, "mimic", None, joint=leader, **words)
    effort = {"effort": _effort(c), "velocity": min(c.max_velocity, NO_LIMIT)}
    if node.get("type") != "continuous":
        limits = {"lower": max(c.lower, -NO_LIMIT), "upper": min(c.upper, NO_LIMIT)} | effort
        element(node, "limit", None, **{key: numbers([value]) for key, value in limits.items()})
    elif min(effort.values()) < NO_LIMIT:
        element(node, "limit", None, **{key: numbers([value]) for key, value in effort.items()})
    friction = {"friction": numbers([c.friction])} if c.friction else {}
    element(node, "dynamics", damping=numbers([c.damping]), **friction)


def _type(single: SingleJoint) -> str:
    if single.motion is None or single.coordinate is None:
        return "fixed"
    if single.motion.kind == "translation":
        return "prismatic"
    shown = _coordinate_to_write(single.name, single.coordinate)
    return "revolute" if shown.is_limited else "continuous"


def _coordinate_to_write(name: str, c: Coordinate) -> Coordinate:
    """Return the coordinate to write in a joint element; an empty one for a following joint."""
    if name != c.name:
        return Coordinate(name)
    return replace(c, lower=c.initial, upper=c.initial) if c.locked else c


def _effort(coordinate: Coordinate) -> float:
    return min(max(abs(coordinate.tau_min), abs(coordinate.tau_max)), NO_LIMIT)


def _origin(parent: ElementTree.Element, pose: Pose) -> None:
    element(parent, "origin", xyz=numbers(pose.position), rpy=numbers(pose.rpy))
