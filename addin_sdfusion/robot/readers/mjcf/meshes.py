"""Meshes of MJCF: their files, what is seen, and their mass where geoms take it from them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import Any, NamedTuple

from ...errors import InputError
from ...finding_builders import unknown
from ...formats.reading.xml import Node
from ...mesh_files import is_file, mesh_bytes, mesh_file
from ...model.pose import Vector3
from ...model.robot import SHAPE_SIZES, Mesh, Shape, ShapeKind
from ...model.rotations import Matrix3
from .bodies import Body, Part
from .compiler import Compiler
from .document import MAIN, Document, note_absolute
from .shapes import place_of, shape_of, sizes_of

LEGACY = "legacy"
"""How MuJoCo fills meshes unless they say otherwise."""
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
            data = mesh_bytes(file, None)  # whether it may travel is for those who pack it
        except InputError:
            return None
        note_absolute(node, self.uri(name))
        node.notes.files.append(file)
        return _solid_of(data, file.suffix, self.scale(name), node.attribute("inertia", LEGACY))


def _solid_of(data: bytes, suffix: str, scale: Vector3, way: str) -> Solid | None:
    """The solid of a mesh, as MuJoCo fills it; None without trimesh, and for what is not filled.

    Args:
        data: Its file.
        suffix: Of the file's name.
        scale: By what it is scaled.
        way: `legacy` for tetrahedra that all count as positive, `exact`, or `convex` for its hull.
    """
    if way not in (LEGACY, "exact", "convex"):
        return None
    try:
        import trimesh  # of the extra `viewer`
    except ImportError:
        return None
    import io

    try:
        kind = suffix[1:].lower()
        mesh: Any = trimesh.load(io.BytesIO(data), file_type=kind, force="mesh", process=False)
        mesh.apply_scale(scale)
        corners = (mesh.convex_hull if way == "convex" else mesh).triangles
        doubled = trimesh.triangles.cross(corners)  # the normals, twice the areas long
        return _fill(corners, doubled, way == LEGACY)
    except Exception:  # trimesh raises what its parsers raise
        return None


def _fill(corners: Any, doubled: Any, is_legacy: bool) -> Solid | None:
    """Tetrahedra from triangles to a point: first the mean of the surface, then their centre.

    Args:
        corners: Of the triangles, shape (n, 3, 3).
        doubled: Their normals, as long as twice their areas, shape (n, 3).
        is_legacy: Whether a tetrahedron counts the same whichever way its triangle looks.
    """
    middles = corners.mean(axis=1)
    areas = (doubled * doubled).sum(axis=1) ** 0.5

    def volumes(point: Any) -> Any:
        signed = ((middles - point) * doubled).sum(axis=1) / 6.0
        return abs(signed) if is_legacy else signed

    mean = (areas[:, None] * middles).sum(axis=0) / areas.sum()
    parts = volumes(mean)
    centre = (parts[:, None] * (0.75 * middles + 0.25 * mean)).sum(axis=0) / parts.sum()
    parts, arms = volumes(centre), corners - centre
    sums = arms.sum(axis=1)
    second = (parts[:, None] * sums).T @ sums
    for k in range(3):
        second = second + (parts[:, None] * arms[:, k]).T @ arms[:, k]
    second = second / 20.0
    volume, trace = float(parts.sum()), float(second.trace())
    inertia = [
        [(trace if i == j else 0.0) - float(second[i, j]) for j in range(3)] for i in range(3)
    ]
    if not (volume > 0.0 and math.isfinite(volume + trace)):
        return None
    x, y, z = (float(entry) for entry in centre)
    rows: Any = tuple((row[0], row[1], row[2]) for row in inertia)
    return Solid(volume, (x, y, z), rows)
