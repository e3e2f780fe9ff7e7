"""Bodies, their meshes, vertices, edges and faces."""

from __future__ import annotations

import math
from typing import Any

from ..base import Base, api, new
from ..collections_ import Items, listing, named
from ..curves import bounding_box, curve_of, surface_of
from ..maths import point
from ..state import world
from .appearances import Appearance
from .data import BodyData, TopologyData
from .entity import Deletable, Placed, WithName, WithVisibility, wrap, wraps
from .physical import physical_properties

_SEGMENTS = {8: 12, 11: 24, 13: 48, 15: 96}
"""Number of sides of a circle, by TriangleMeshQualityOptions."""


class _Body(Placed, WithName, WithVisibility, Deletable):
    parentComponent = property(lambda self: wrap(self._data.component))

    @property
    def material(self) -> Any:
        from .component import material

        return material(self._data.material)

    appearance = property(lambda self: new(Appearance, rgb=self._data.color))

    @property
    def boundingBox(self) -> Any:
        """Exact bounding box along the axes of the context."""
        return bounding_box(self._data.shape.bounds(self._T))


@api("adsk.fusion")
@wraps((BodyData, "solid"), (BodyData, "surface"))
class BRepBody(_Body):
    def _shelf(self) -> list[Any]:
        return self._data.component.bodies

    @property
    def visibleOpacity(self) -> float:
        """Opacity, including the opacities of the parent components."""
        above = [self._data.component, *(o.parent for o in self._path)]
        return self._data.opacity * math.prod(c.opacity for c in above)

    isSolid = property(lambda self: self._data.kind == "solid")
    volume = property(lambda self: float(self._data.mass().volume))

    def getPhysicalProperties(self, accuracy: int = 0) -> Any:
        return self._physical(accuracy)

    def _physical(self, accuracy: int) -> Any:
        return physical_properties(self._data.mass(), accuracy, self._T)

    meshManager = property(lambda self: new(MeshManager, body=self))
    vertices = property(lambda self: new(BRepVertices, body=self, part=0))
    edges = property(lambda self: new(BRepEdges, body=self, part=1))
    faces = property(lambda self: new(BRepFaces, body=self, part=2))


@api("adsk.fusion")
@wraps((BodyData, "mesh"))
class MeshBody(_Body):
    def _shelf(self) -> list[Any]:
        return self._data.component.mesh_bodies

    displayMesh = property(lambda self: _triangle_mesh(self, _SEGMENTS[11]))


class _Bodies(Items):
    """Bodies of a component; `_component` is ComponentData, `_path` the context."""

    def _all(self) -> list[Any]:
        return [wrap(body, self._path) for body in self._shelf()]


@api("adsk.fusion")
@named
class BRepBodies(_Bodies):
    def _shelf(self) -> list[Any]:
        return self._component.bodies


@api("adsk.fusion")
@listing
class MeshBodies(_Bodies):
    def _shelf(self) -> list[Any]:
        return self._component.mesh_bodies


@api("adsk.fusion")
class MeshManager(Base):
    parent = property(lambda self: self._body)

    def createMeshCalculator(self) -> Any:
        return new(TriangleMeshCalculator, manager=self, segments=_SEGMENTS[11], tolerance=0.0)


@api("adsk.fusion")
class TriangleMeshCalculator(Base):
    def setQuality(self, triangleMeshQuality: int) -> bool:
        if triangleMeshQuality not in _SEGMENTS:
            raise RuntimeError("3 : invalid argument triangleMeshQuality")
        self._segments = _SEGMENTS[triangleMeshQuality]
        return True

    def calculate(self) -> Any:
        """Return the mesh; the surface tolerance determines the number of sides of a circle."""
        segments, shape = self._segments, self._manager._body._data.shape
        radius = max(getattr(shape, "radius", 0.0), getattr(shape, "major", 0.0))
        if self._tolerance > 0.0 and radius > self._tolerance:
            half = math.acos(1.0 - self._tolerance / radius)
            segments = max(4, math.ceil(math.pi / half))
        return _triangle_mesh(self._manager._body, segments)


def _triangle_mesh(body: Any, segments: int) -> Any:
    nodes, triangles = body._data.shape.mesh(segments)
    if world().options.mesh_frame == "context":
        nodes = nodes @ body._T[:3, :3].T + body._T[:3, 3]
    return new(TriangleMesh, nodes=nodes, triangles=triangles)


@api("adsk.fusion")
class TriangleMesh(Base):
    """Triangle mesh with nodes in cm."""

    nodeCoordinatesAsDouble = property(lambda self: self._nodes.ravel().tolist())
    nodeIndices = property(lambda self: self._triangles.ravel().tolist())


class _Topology(Placed):
    def _is_gone(self) -> bool:
        return super()._is_gone() or self._is_before(world().recomputes)

    body = property(lambda self: wrap(self._data.body, self._path))


class _TopologyItems(Items):
    def _all(self) -> list[Any]:
        return [wrap(t, self._body._path) for t in self._body._data.topology()[self._part]]


@api("adsk.fusion")
@wraps((TopologyData, "vertex"))
class BRepVertex(_Topology):
    geometry = property(lambda self: point(self._placed(self._data.geometry)))


@api("adsk.fusion")
@wraps((TopologyData, "edge"))
class BRepEdge(_Topology):
    geometry = property(lambda self: curve_of(self._data.geometry, self._T))
    length = property(lambda self: self._data.geometry.length)


@api("adsk.fusion")
@wraps((TopologyData, "face"))
class BRepFace(_Topology):
    geometry = property(lambda self: surface_of(self._data.geometry, self._T))

    edges = property(lambda self: new(_FaceEdges(), body=self.body, face=self._data))


def _FaceEdges() -> type:
    return BRepEdges


@api("adsk.fusion")
@listing
class BRepVertices(_TopologyItems):
    pass


@api("adsk.fusion")
@listing
class BRepEdges(_TopologyItems):
    """Edges of a body, or of one of its faces."""

    _face: Any = None
    _part = 1

    def _all(self) -> list[Any]:
        edges = super()._all()
        if self._face is None:
            return edges
        return [e for e in edges if _bounds(self._face.geometry, e._data.geometry)]


@api("adsk.fusion")
@listing
class BRepFaces(_TopologyItems):
    pass


def _bounds(face: Any, edge: Any) -> bool:
    """Return whether an edge bounds a face of a shape."""
    if face.kind == "cylinder":
        return edge.radius > 0.0
    if face.kind != "plane":
        return False
    ends = [edge.centre, edge.centre + edge.axis * (edge.length if edge.radius == 0.0 else 0.0)]
    return all(abs((p - face.origin) @ face.axis) < 1e-9 for p in ends)
