"""Reader of OpenSim bodies: masses and visual meshes."""

from __future__ import annotations

from collections.abc import Iterator

from ....mesh_files import is_file
from ....model.pose import IDENTITY, Pose
from ....model.robot import Inertia, Link, Mesh
from ...reading.xml import ZERO, Node
from .document import objects, text
from .frames import Frames, pose_of

GEOMETRY = "Geometry"
"""Folder in which OpenSim searches for meshes."""


def read_body(node: Node, frames: Frames) -> Link:
    """Return a link, with the meshes of the body and of the frames that are fixed to it."""
    name = node.subject.name
    meshes = list(_meshes(node, IDENTITY))
    for path, frame in frames.offsets(name):
        _, T_link_frame = frames.place(frame, "socket_parent", path)
        meshes += _meshes(frame, pose_of(T_link_frame))
    com = node.vector("mass_center") if node.all("mass_center") else ZERO
    inertia = node.optional("inertia")
    xx, yy, zz, xy, xz, yz = (0.0,) * 6 if inertia is None else inertia.numbers(6)
    body_inertia = Inertia(node.number("mass", 0.0), com, xx, yy, zz, xy, xz, yz)
    return Link(name, body_inertia, meshes=tuple(meshes))


def _meshes(node: Node, pose: Pose) -> Iterator[Mesh]:
    for group in node.all("attached_geometry"):
        for child in group.all("Mesh"):
            name = text(child, "mesh_file")
            if not name:
                continue
            inside = f"{GEOMETRY}/{name}"
            uri = inside if is_file(node.file.parent / inside) else name
            factors = child.vector("scale_factors") if child.all("scale_factors") else (1.0,) * 3
            x, y, z = factors
            yield Mesh("visual", uri, pose, (x, y, z))


def note_shapes(model: Node) -> None:
    """Report shapes that are not meshes, in one warning."""
    bodies = [*model.all("Ground"), *objects(model, "BodySet")]
    shapes = [
        shape
        for body in bodies
        for group in body.all("attached_geometry")
        for shape in group.all()
        if shape.tag != "Mesh"
    ]
    if shapes:
        kinds = ", ".join(sorted({shape.tag for shape in shapes}))
        shapes[0].warning("geometry-left-out", f"only meshes are read; omitted: {kinds}")
