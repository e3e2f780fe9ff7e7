"""Writer of links as OpenSim bodies."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

from ....model.pose import IDENTITY, Pose, Vector3
from ....model.robot import WORLD, Inertia, Link, Mesh
from ....model.rotations import Matrix3, rotation, rpy, transpose
from ...writing.xml_text import element, numbers
from .names import GROUND

MIN_MASS = 1e-12
"""In [kg]; OpenSim ignores the inertia of a massless body and rejects two of them in a row."""


def objects(parent: ElementTree.Element, tag: str, name: str) -> ElementTree.Element:
    """Add a named set and return the parent element of its objects."""
    return element(element(parent, tag, name=name), "objects")


def frame_path(link: str) -> str:
    """Return the path of the frame of a link in OpenSim."""
    return f"/{GROUND}" if link == WORLD else f"/bodyset/{link}"


def placement(parent: ElementTree.Element, tags: tuple[str, str], p: Vector3, R: Matrix3) -> None:
    """Add a position and the angles of R = Rx(a) Ry(b) Rz(c), as used by OpenSim."""
    a, b, c = rpy(transpose(R))  # the inverse rotation has negative angles in reverse order
    element(parent, tags[0], numbers(p))
    element(parent, tags[1], numbers((0.0 - a, 0.0 - b, 0.0 - c)))


def add_frame(frames: ElementTree.Element, name: str, link: str, T: Pose) -> None:
    """Add a frame with an offset from the frame of a link."""
    frame = element(frames, "PhysicalOffsetFrame", name=name)
    element(frame, "socket_parent", frame_path(link))
    placement(frame, ("translation", "orientation"), T.position, rotation(T.rpy))


def add_body(
    bodies: ElementTree.Element, link: Link, files: Mapping[str, str | Path], min_mass: float
) -> ElementTree.Element:
    """Add a link.

    Args:
        files: Mesh file by URI.
        min_mass: Minimum mass to write, in [kg].
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
    _add_mass(node, link.inertia, min_mass)
    return node


def add_massless(bodies: ElementTree.Element, name: str) -> None:
    """Add a massless body between the single joints of a chain."""
    _add_mass(element(bodies, "Body", name=name), Inertia(0.0), MIN_MASS)


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


def _add_mass(body: ElementTree.Element, inertia: Inertia, min_mass: float) -> None:
    element(body, "mass", max(inertia.mass, min_mass))
    element(body, "mass_center", numbers(inertia.com))
    element(body, "inertia", numbers(inertia.entries))
