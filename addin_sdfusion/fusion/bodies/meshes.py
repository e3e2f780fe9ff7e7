"""Triangle meshes of bodies from Fusion's mesh calculator, in the root frame."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import adsk.fusion

from ...robot.finding import Subject
from ...robot.model.pose import Vector3
from ...settings import MeshQuality
from ...snapshot import MeshSnapshot
from ..notes import Notes, optional
from ..occurrences import Occurrence
from ..units import CM, position

_MAX_OUTSIDE = 1e-3  # of nodes outside the bounding box, relative to its diagonal
_MAX_SLACK = 0.25  # between the mesh and the bounding box, relative to its diagonal


@dataclass(frozen=True)
class _Triangles:
    """Triangles of a Fusion mesh; fields as in a MeshSnapshot."""

    nodes: array[float]
    indices: array[int]


class Mesher:
    """Mesh calculator that calculates the meshes of each component only once.

    The frame of the mesh of a proxy is not documented. Therefore the native body is meshed in the
    frame of its component, and the nodes are transformed by the pose of the occurrence. The result
    is compared with the bounding box of the body in the root frame. If the box fits the original
    nodes instead, these are used.
    """

    def __init__(self, quality: MeshQuality, notes: Notes) -> None:
        options = adsk.fusion.TriangleMeshQualityOptions
        self._quality = {
            "low": options.LowQualityTriangleMesh,
            "normal": options.NormalQualityTriangleMesh,
            "high": options.HighQualityTriangleMesh,
            "very_high": options.VeryHighQualityTriangleMesh,
        }[quality]
        self._notes = notes
        self._meshes: dict[tuple[str, str, str], _Triangles] = {}

    def mesh(
        self, native: Any, proxy: Any, kind: str, occurrence: Occurrence, subject: Subject
    ) -> MeshSnapshot:
        """Return the mesh of a body in an occurrence.

        Raises:
            ValueError: The body has no mesh.
        """
        # Copies of a document have the same ids, so the key includes names.
        key = occurrence.component.id, occurrence.component.name, f"{kind} {native.name}"
        if key not in self._meshes:
            raw = self._surface(native) if kind != "mesh" else native.displayMesh
            self._meshes[key] = _orient_outwards(_triangles(raw), closed=kind == "solid")
        mesh = self._meshes[key]
        nodes = self._to_root_frame(mesh.nodes, proxy, occurrence, subject)
        return MeshSnapshot(nodes, mesh.indices)

    def _surface(self, body: Any) -> Any:
        calculator = body.meshManager.createMeshCalculator()
        calculator.setQuality(self._quality)
        return calculator.calculate()

    def _to_root_frame(
        self, nodes: array[float], proxy: Any, occurrence: Occurrence, subject: Subject
    ) -> array[float]:
        placed = occurrence.T.apply_all(nodes)
        box = optional(lambda: bounding_box(proxy))
        if box is None or _fits(placed, box):
            return placed
        if _fits(nodes, box):
            return nodes
        self._notes.warn(
            subject,
            "mesh-elsewhere",
            f"body {subject.name!r}: its mesh and bounding box differ. Check the exported mesh, "
            "and please report this with the snapshot of the design",
        )
        return placed


def bounding_box(body: Any) -> tuple[Vector3, Vector3]:
    """Return the minimum and maximum corner of a body's box in the root frame, in [m]."""
    box = body.boundingBox
    return position(box.minPoint), position(box.maxPoint)


def _triangles(mesh: Any) -> _Triangles:
    """Return the triangles of a TriangleMesh, in [m]."""
    if mesh is None:
        raise ValueError("Fusion returned no mesh")
    nodes = array("d", (value * CM for value in mesh.nodeCoordinatesAsDouble))
    indices = array("i", mesh.nodeIndices)
    if not indices:
        raise ValueError("it has no triangles")
    if len(nodes) % 3 or len(indices) % 3 or not 0 <= min(indices) <= max(indices) < len(nodes) / 3:
        raise ValueError("a triangle refers to a node that does not exist")
    return _Triangles(nodes, indices)


def _orient_outwards(mesh: _Triangles, *, closed: bool) -> _Triangles:
    """Return a mesh with triangles counter-clockwise seen from outside, if it is closed.

    The volume enclosed by such triangles is positive.
    """
    if not closed or _volume(mesh) >= 0.0:
        return mesh
    turned = array("i", mesh.indices)
    turned[1::3], turned[2::3] = mesh.indices[2::3], mesh.indices[1::3]
    return _Triangles(mesh.nodes, turned)


def _volume(mesh: _Triangles) -> float:
    """Return the volume of a closed mesh, in [m³], relative to its first node for accuracy."""
    x, y, z = mesh.nodes[0::3], mesh.nodes[1::3], mesh.nodes[2::3]
    x0, y0, z0 = x[0], y[0], z[0]
    total = 0.0
    for k in range(0, len(mesh.indices), 3):
        a, b, c = mesh.indices[k : k + 3]
        ax, ay, az = x[a] - x0, y[a] - y0, z[a] - z0
        bx, by, bz = x[b] - x0, y[b] - y0, z[b] - z0
        cx, cy, cz = x[c] - x0, y[c] - y0, z[c] - z0
        total += ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return total / 6.0


def _fits(nodes: Sequence[float], box: tuple[Vector3, Vector3]) -> bool:
    """Return whether nodes are inside a bounding box and nearly fill it."""
    low, high = box
    size = max(b - a for a, b in zip(low, high, strict=True))
    for k in range(3):
        values = nodes[k::3]
        below, above = min(values) - low[k], high[k] - max(values)
        if min(below, above) < -_MAX_OUTSIDE * size or max(below, above) > _MAX_SLACK * size:
            return False
    return True
