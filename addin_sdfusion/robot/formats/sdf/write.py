"""Writer of SDF 1.7 model folders.

Links and joints are placed such that both poses of a joint are restored without rounding errors: a
joint is relative to its parent link, and a link to its parent joint. Loop joints come last, each
with a frame for its end on the child link, whose drawn pose may differ. A joint whose motions SDF
does not support is a chain of single joints. Data that SDF does not support is in the plugin
element, see `plugin`.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from ...checks.check import require_valid
from ...files import write_files
from ...model.joint import Coordinate
from ...model.pose import Pose
from ...model.robot import WORLD, Inertia, Link, Robot
from ...model.rotations import inverse
from ..capability import require_writable
from ..cardsflow.write import cardsflow_xml
from ..writing.xml_text import document, element, numbers
from .capabilities import sdf_losses
from .names import MODEL_FRAME, NO_LIMIT, joint_frame_name, mesh_names, needs_frame, shape_names
from .plugin import extras_text, plugin_element
from .write_joints import SdfJoint, sdf_joints, sdf_loops


def write_sdf(robot: Robot, folder: str | Path, *, plugin: bool = True) -> list[Path]:
    """Write model.sdf, model.config and cardsflow.xml.

    Args:
        folder: Output folder; created if it does not exist.
        plugin: Whether to write data that SDF does not support to a plugin element of model.sdf,
            whose library exists for Gazebo 9. Otherwise it is written to cardsflow.xml, and no
            program searches for the library.

    Raises:
        RobotError: The robot has errors, or SDF cannot hold it; `sdf_losses` lists all causes.
        InputError: The folder cannot be written.
    """
    require_valid(robot)
    require_writable(sdf_losses(robot), "sdf")
    texts = {
        "model.sdf": _model_sdf(robot, plugin),
        "model.config": _model_config(robot),
        "cardsflow.xml": cardsflow_xml(robot) if plugin else extras_text(robot),
    }
    return write_files(folder, texts)


def _model_sdf(robot: Robot, plugin: bool) -> str:
    root = element(None, "sdf", version="1.7")
    model = element(root, "model", name=robot.name)
    joints = [joint for chain in sdf_joints(robot).values() for joint in chain]
    carriers = {joint.child: joint for joint in joints}
    massless = [Link(joint.child, Inertia(0.0)) for joint in joints if joint.between]
    for link in (*robot.links, *massless):
        _link(model, link, carriers[link.name])
    for joint in (*joints, *sdf_loops(robot)):
        _joint(model, joint)
    if plugin:
        plugin_element(model, robot)
    return document(root)


def _link(model: ElementTree.Element, link: Link, carrier: SdfJoint) -> None:
    node = element(model, "link", name=link.name)
    _pose(node, inverse(carrier.T_child_joint), carrier.name)
    inertial = element(node, "inertial")
    _pose(inertial, Pose(link.inertia.com))
    element(inertial, "mass", link.inertia.mass)
    inertia = element(inertial, "inertia")
    for entry in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
        element(inertia, entry, getattr(link.inertia, entry))
    for mesh, name in zip(link.meshes, mesh_names(link), strict=True):
        looks = element(node, mesh.role, name=name)
        _pose(looks, mesh.pose)
        geometry = element(element(looks, "geometry"), "mesh")
        element(geometry, "uri", mesh.uri)
        element(geometry, "scale", numbers(mesh.scale))
        if mesh.color is not None:
            material = element(looks, "material")
            for light in ("ambient", "diffuse"):
                element(material, light, numbers(mesh.color))
    for shape, name in zip(link.shapes, shape_names(link), strict=True):
        collision = element(node, "collision", name=name)
        _pose(collision, shape.pose)
        geometry = element(element(collision, "geometry"), shape.kind)
        if shape.kind == "box":
            element(geometry, "size", numbers(shape.sizes))
        for tag, size in zip(("radius", "length"), shape.sizes, strict=False):
            if shape.kind != "box":
                element(geometry, tag, size)


def _joint(model: ElementTree.Element, joint: SdfJoint) -> None:
    node = element(model, "joint", name=joint.name, type=joint.type)
    _pose(node, joint.T_parent_joint, MODEL_FRAME if joint.parent == WORLD else joint.parent)
    element(node, "parent", joint.parent)
    element(node, "child", joint.child)
    for tag, coordinate, motion in zip(
        ("axis", "axis2"), joint.coordinates, joint.motions, strict=False
    ):
        axis = element(node, tag)
        element(axis, "xyz", numbers(motion.axis))
        if joint.closes_loop:
            continue
        limit = element(axis, "limit")
        element(limit, "lower", max(coordinate.lower, -NO_LIMIT))
        element(limit, "upper", min(coordinate.upper, NO_LIMIT))
        effort = max(abs(coordinate.tau_min), abs(coordinate.tau_max))
        if effort < NO_LIMIT:
            element(limit, "effort", effort)
        if coordinate.max_velocity < NO_LIMIT:
            element(limit, "velocity", coordinate.max_velocity)
        _dynamics(axis, coordinate)
    if joint.closes_loop or needs_frame(joint.T_child_joint):
        name = joint_frame_name(joint.name, joint.child)
        _pose(element(model, "frame", name=name, attached_to=joint.child), joint.T_child_joint)


def _dynamics(axis: ElementTree.Element, coordinate: Coordinate) -> None:
    node = element(axis, "dynamics")
    element(node, "damping", coordinate.damping)
    if coordinate.friction:
        element(node, "friction", coordinate.friction)
    if coordinate.stiffness or coordinate.rest:
        element(node, "spring_reference", coordinate.rest)
        element(node, "spring_stiffness", coordinate.stiffness)


def _pose(parent: ElementTree.Element, pose: Pose, relative_to: str | None = None) -> None:
    attributes = {} if relative_to is None else {"relative_to": relative_to}
    element(parent, "pose", numbers((*pose.position, *pose.rpy)), **attributes)


def _model_config(robot: Robot) -> str:
    root = element(None, "model")
    element(root, "name", robot.name)
    element(root, "version", "1.0")
    element(root, "sdf", "model.sdf", version="1.7")
    element(element(root, "author"), "name", "")
    element(root, "description", "A musculoskeletal robot, written by CARDSFlow.")
    return document(root)
