"""Selection filters, which specify the entities that a selection input accepts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from .data import (
    BodyData,
    ComponentData,
    JointData,
    JointOriginData,
    OccurrenceData,
    PointData,
    SketchData,
    SketchPointData,
    TopologyData,
)


def _body(*kinds: str) -> Callable[[Any], bool]:
    return lambda data: isinstance(data, BodyData) and data.kind in kinds


def _face(*kinds: str) -> Callable[[Any], bool]:
    def fits(data: Any) -> bool:
        is_face = isinstance(data, TopologyData) and data.kind == "face"
        return is_face and (not kinds or data.geometry.kind in kinds)

    return fits


def _edge(fits: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda data: (
        isinstance(data, TopologyData) and data.kind == "edge" and fits(data.geometry)
    )


def _of(cls: type) -> Callable[[Any], bool]:
    return lambda data: isinstance(data, cls)


def _none(_: Any) -> bool:
    return False


FILTERS: dict[str, Callable[[Any], bool]] = {
    "Bodies": _body("solid", "surface"),
    "SolidBodies": _body("solid"),
    "SurfaceBodies": _body("surface"),
    "MeshBodies": _body("mesh"),
    "Faces": _face(),
    "SolidFaces": _face(),
    "SurfaceFaces": _none,
    "PlanarFaces": _face("plane"),
    "CylindricalFaces": _face("cylinder"),
    "ConicalFaces": _none,
    "SphericalFaces": _face("sphere"),
    "ToroidalFaces": _face("torus"),
    "SplineFaces": _none,
    "Edges": _edge(lambda _: True),
    "LinearEdges": _edge(lambda edge: edge.radius == 0.0),
    "CircularEdges": _edge(lambda edge: edge.radius > 0.0),
    "EllipticalEdges": _none,
    "TangentEdges": _none,
    "NonTangentEdges": _edge(lambda _: True),
    "Vertices": lambda data: isinstance(data, TopologyData) and data.kind == "vertex",
    "RootComponents": _of(ComponentData),
    "Occurrences": _of(OccurrenceData),
    "Sketches": _of(SketchData),
    "SketchConstraints": _none,
    "Profiles": _none,
    "Texts": _none,
    "SketchCurves": _none,
    "SketchLines": _none,
    "SketchCircles": _none,
    "SketchPoints": _of(SketchPointData),
    "ConstructionPoints": _of(PointData),
    "ConstructionLines": _none,
    "ConstructionPlanes": _none,
    "Features": _none,
    "Canvases": _none,
    "Decals": _none,
    "JointOrigins": _of(JointOriginData),
    "Joints": _of(JointData),
}
"""Filters of the user manual, with tests of the data that they accept."""


def passes(entity: Any, filters: Sequence[str]) -> bool:
    """Return whether an entity may be selected; without filters every entity may."""
    return not filters or any(FILTERS[name](entity._data) for name in filters)
