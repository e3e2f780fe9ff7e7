"""Links and joints in OpenSim: bodies in their own frames, pins, sliders and welds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

from ...model.joint import Coordinate, Motion
from ...model.pose import IDENTITY, Pose, Vector3
from ...model.robot import WORLD, Inertia, Link, Mesh
from ...model.rotations import Matrix3, cross, multiply, normalized, rotation, rpy, transpose
from ...transforms.joint_chains import SingleJoint
from ..xml_text import element, numbers
from .names import GROUND

LEAST_MASS = 1e-12
"""In [kg]: OpenSim takes away the inertia of a body without mass, and refuses two such in a row."""
JOINTS = {"rotation": "PinJoint", "translation": "SliderJoint"}


def objects(parent: ElementTree.Element, tag: str, name: str) -> ElementTree.Element:
    """A named set of objects; returns the parent of its objects."""
    return element(element(parent, tag, name=name), "objects")


def frame_path(link: str) -> str:
    """Where OpenSim finds the frame of a link."""
    return f"/{GROUND}" if link == WORLD else f"/bodyset/{link}"


def placement(parent: ElementTree.Element, tags: tuple[str, str], p: Vector3, R: Matrix3) -> None:
    """Add a position and the angles of R = Rx(a) Ry(b) Rz(c), OpenSim's order.

    Args:
        parent: Where to.
        tags: The words for the position and for the angles.
        p: In [m].
        R: The rotation matrix.
    """
    a, b, c = rpy(transpose(R))  # the inverse turns by the negative angles, about z first
    element(parent, tags[0], numbers(p))
    element(parent, tags[1], numbers((0.0 - a, 0.0 - b, 0.0 - c)))


def add_body(
    bodies: ElementTree.Element, link: Link, files: Mapping[str, str | Path]
) -> ElementTree.Element:
    """Add a link.

    Returns:
        Its body.
    """
    node = element(bodies, "Body", name=link.name)
    visual = [mesh for mesh in link.meshes if mesh.role == "visual"]
    _add_meshes(node, [m for m in visual if m.pose == IDENTITY], files)
    placed = [mesh for mesh in visual if mesh.pose != IDENTITY]
    components = element(node, "components") if placed else node
    for k, mesh in enumerate(placed, start=1):
        frame = element(components, "PhysicalOffsetFrame", name=f"mesh_frame_{k}")
        _add_meshes(frame, [mesh], files)
        element(frame, "socket_parent", "..")
        tags = ("translation", "orientation")
        placement(frame, tags, mesh.pose.position, rotation(mesh.pose.rpy))
    _add_mass(node, link.inertia)
    return node


def add_massless(bodies: ElementTree.Element, name: str) -> None:
    """Add a body between the single joints of a chain."""
    _add_mass(element(bodies, "Body", name=name), Inertia(0.0))


def add_joint(joints: ElementTree.Element, single: SingleJoint) -> None:
    """Add a single joint; a pin turns about the z axis, a slider moves along the x axis."""
    motion = single.motion
    node = element(joints, "WeldJoint" if motion is None else JOINTS[motion.kind], name=single.name)
    element(node, "socket_parent_frame", "parent_offset")
    element(node, "socket_child_frame", "child_offset")
    if single.coordinate is not None:
        _add_coordinate(element(node, "coordinates"), single.coordinate)
    frames = element(node, "frames")
    for name, link, pose in (
        ("parent_offset", single.parent, single.T_parent_joint),
        ("child_offset", single.child, single.T_child_joint),
    ):
        _add_frame(frames, name, link, pose, motion)


def _add_frame(
    frames: ElementTree.Element, name: str, link: str, pose: Pose, motion: Motion | None
) -> None:
    R = rotation(pose.rpy)
    if motion is not None:
        R = multiply(R, _axes_of(motion))
    frame = element(frames, "PhysicalOffsetFrame", name=name)
    element(frame, "socket_parent", frame_path(link))
    placement(frame, ("translation", "orientation"), pose.position, R)


def _axes_of(motion: Motion) -> Matrix3:
    """Axes of a pin or slider in the joint frame, column by column."""
    a = normalized(motion.axis)
    least = min(range(3), key=lambda i: abs(a[i]))
    other: Vector3 = (float(least == 0), float(least == 1), float(least == 2))
    b = normalized(cross(a, other))
    c = cross(a, b)
    return transpose((b, c, a) if motion.kind == "rotation" else (a, b, c))


def _add_coordinate(parent: ElementTree.Element, c: Coordinate) -> None:
    node = element(parent, "Coordinate", name=c.name)
    locked = c.lower == c.upper
    element(node, "default_value", c.lower if locked else c.initial)
    element(node, "range", numbers((c.lower, c.upper)))
    limited = math.isfinite(c.lower) or math.isfinite(c.upper)
    element(node, "clamped", _word(limited and c.lower <= c.initial <= c.upper))
    element(node, "locked", _word(locked))


def _word(value: bool) -> str:
    return "true" if value else "false"


def _add_meshes(
    parent: ElementTree.Element, meshes: list[Mesh], files: Mapping[str, str | Path]
) -> None:
    if not meshes:
        return
    geometry = element(parent, "attached_geometry")
    for k, mesh in enumerate(meshes, start=1):
        node = element(geometry, "Mesh", name=f"mesh_{k}")
        element(node, "socket_frame", "..")
        element(node, "scale_factors", numbers(mesh.scale))
        if mesh.color is not None:
            looks = element(node, "Appearance")
            element(looks, "opacity", mesh.color[3])
            element(looks, "color", numbers(mesh.color[:3]))
        element(node, "mesh_file", str(files.get(mesh.uri, mesh.uri)))


def _add_mass(body: ElementTree.Element, inertia: Inertia) -> None:
    i = inertia
    element(body, "mass", max(i.mass, LEAST_MASS))
    element(body, "mass_center", numbers(i.com))
    element(body, "inertia", numbers((i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz)))
