"""Meshes of MJCF: their files, what is seen, and their mass where geoms take it from them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import PurePosixPath
from typing import Any, NamedTuple

from ...errors import InputError
from ...finding_builders import unknown
from ...mesh_files import is_file, mesh_bytes, mesh_file
from ...model.pose import Vector3
from ...model.robot import SHAPE_SIZES, Mesh, Shape, ShapeKind
from ...model.rotations import Matrix3
from ..xml import Node
from .bodies import Body, Part
from .compiler import Compiler
from .document import MAIN, Document
from .shapes import place_of, shape_of, sizes_of

COLLISION_GROUP = 4
"""What our own files put collision meshes in."""


def collision_kind(part: Part) -> ShapeKind | None:
    """What shape a geom is that our own files say a link collides with; None for any other."""
    kind = shape_of(part.node)
    return kind if _in_collision_group(part) and kind in SHAPE_SIZES else None


def _in_collision_group(part: Part) -> bool:
    return part.node.number_attribute("group", 0.0) == COLLISION_GROUP


class Solid(NamedTuple):
    """A mesh filled with a density of 1 kg/m³.

    Attributes:
        volume: In [m³].
        centre: Its centre of mass in the mesh's frame, in [m].
        inertia: About the centre.
    """

    volume: float
    centre: Vector3
    inertia: Matrix3


class MeshAssets:
    """The meshes that a file names.

    Attributes:
        missing: For each body, the files that its mass would come from and that are not there, or
            cannot be used.
    """

    def __init__(self, document: Document, compiler: Compiler) -> None:
        self._compiler = compiler
        self._folder = document.root.file.parent
        self._nodes: dict[str, Node] = {}
        self._solids: dict[str, Solid | None] = {}
        self.missing: dict[str, list[str]] = {}
        for node in document.parts("asset", "mesh"):
            node = document.with_defaults(node, MAIN)
            name = node.attribute("name", "") or PurePosixPath(node.attribute("file", "")).stem
            self._nodes.setdefault(name, node)

    def uri(self, name: str) -> str:
        """The file of a mesh, from the folder of the model."""
        node = self._nodes[name]
        file = node.attribute("file", "")
        if self._compiler.strips:
            file = PurePosixPath(file).name
        return str(PurePosixPath(self._compiler.mesh_folder) / file)

    def scale(self, name: str) -> Vector3:
        """By what a mesh is scaled."""
        node = self._nodes[name]
        return node.vector_attribute("scale") if node.has("scale") else (1.0, 1.0, 1.0)

    def seen(self, body: Body) -> Iterator[Mesh]:
        """The meshes of a body."""
        for part in body.geoms:
            name = part.node.attribute("mesh", "")
            if not name or shape_of(part.node) != "mesh":
                continue
            if name not in self._nodes:
                part.node.error("unknown-mesh", unknown("mesh", name, list(self._nodes)))
            elif self._nodes[name].has("file"):
                pose = self._compiler.pose(part.node, place_of(part, self._compiler))
                role = "collision" if _in_collision_group(part) else "visual"
                yield Mesh(role, self.uri(name), pose, self.scale(name), name)  # type: ignore[arg-type]

    def collide(self, body: Body) -> Iterator[Shape]:
        """The shapes that a body collides with; MJCF has half the edges and lengths."""
        for part in body.geoms:
            kind = collision_kind(part)
            if kind is not None:
                first, *others = sizes_of(part.node)
                sizes = (first if kind != "box" else 2.0 * first, *(2.0 * size for size in others))
                pose = self._compiler.pose(part.node, place_of(part, self._compiler))
                yield Shape(kind, sizes, pose)

    def solid(self, part: Part) -> Solid | None:
        """The filled mesh of a geom; None where it cannot be had, which is noted in `missing`."""
        name = part.node.attribute("mesh", "")
        if name not in self._nodes:
            self._miss(part, name)
            return None
        if name not in self._solids:
            self._solids[name] = self._filled(name)
        if self._solids[name] is None:
            self._miss(part, self.uri(name) if self._nodes[name].has("file") else name)
        return self._solids[name]

    def _miss(self, part: Part, file: str) -> None:
        self.missing.setdefault(part.link, []).append(file)

    def _filled(self, name: str) -> Solid | None:
        node = self._nodes[name]
        if not node.has("file") or node.has("refpos") or node.has("refquat"):
            return None
        file = mesh_file(self.uri(name), self._folder, [self._folder])
        if not is_file(file):
            return None
        try:
            data = mesh_bytes(file, [self._folder])
        except InputError:
            return None
        return _solid_of(data, file.suffix, self.scale(name))


def _solid_of(data: bytes, suffix: str, scale: Vector3) -> Solid | None:
    """The solid of a mesh that is closed; None without trimesh, and for what is open."""
    try:
        import trimesh  # of the extra `viewer`
    except ImportError:
        return None
    import io

    try:
        mesh: Any = trimesh.load(io.BytesIO(data), file_type=suffix[1:].lower(), force="mesh")
        mesh.apply_scale(scale)
        if not mesh.is_watertight or not mesh.volume > 0.0:
            return None
        values: Sequence[float] = [float(x) for x in mesh.center_mass]
        rows = [[float(x) for x in row] for row in mesh.moment_inertia]
    except Exception:  # trimesh raises what its parsers raise
        return None
    return Solid(
        float(mesh.volume),
        (values[0], values[1], values[2]),
        tuple((row[0], row[1], row[2]) for row in rows),  # type: ignore[arg-type]
    )
