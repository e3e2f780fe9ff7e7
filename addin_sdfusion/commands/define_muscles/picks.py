"""Conversion of entities picked in Fusion to points and surfaces."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import adsk.core
import adsk.fusion

from ...fusion.occurrences import every_occurrence
from ...fusion.units import CM
from ...muscles.mirror import Plane
from ...robot.errors import InputError
from ...robot.model.pose import Vector3
from ...robot.model.rotations import cross, subtract
from ...snapshot import SurfaceSnapshot
from .editor import HANDLE, Pick

_SAME = 1e-5  # [m]
_SAME_DIRECTION = 1e-4  # [rad]


class Picks:
    """Picked entities, by handle."""

    def __init__(self) -> None:
        self._entities: dict[str, Any] = {}

    def entity(self, handle: str) -> Any:
        """Return the picked entity of a handle; None for other handles."""
        return self._entities.get(handle)

    def point(self, entity: Any, key_of: Callable[[Any], str]) -> Pick:
        """Return the pick of an entity that defines a point.

        Args:
            entity: The selected entity: a proxy in the context of the root, or an entity of it.
            key_of: Function that returns the key of a construction point in the snapshot.

        Raises:
            InputError: The entity does not define a point; the message lists valid entities.
        """
        center = self._position(entity)
        occurrence = entity.assemblyContext
        path = occurrence.fullPathName if occurrence else ""
        read_only = bool(problem_of(entity, occurrence))  # stored in the open design
        if isinstance(entity, adsk.fusion.ConstructionPoint) and not read_only:
            return Pick(center, path, key_of(entity), f"Point {entity.name!r}")
        handle = f"{HANDLE}{len(self._entities)}"
        self._entities[handle] = entity
        part = f"What you picked in {occurrence.name!r}" if occurrence else "What you picked"
        return Pick(center, path, handle, part)

    def surface(self, entity: Any, key_of: Callable[[Any], str]) -> Pick:
        """Return the pick of a cylinder or sphere.

        Raises:
            InputError: The face is not a cylinder or sphere.
        """
        shape = entity.geometry
        occurrence = entity.assemblyContext
        path = occurrence.fullPathName if occurrence else ""
        if isinstance(shape, adsk.core.Sphere):
            face = SurfaceSnapshot(path, "sphere", shape.radius * CM, _metres(shape.origin))
        elif isinstance(shape, adsk.core.Cylinder):
            axis = shape.axis.x, shape.axis.y, shape.axis.z
            centre = _metres(shape.origin)
            face = SurfaceSnapshot(path, "cylinder", shape.radius * CM, centre, axis)
        else:
            raise InputError("Muscles can wrap only over cylinders and spheres; pick such a face.")
        key = key_of(entity)
        self._entities[key] = entity
        part, problem = f"The face of {entity.body.name!r}", problem_of(entity, occurrence)
        return Pick(face.centre, path, key, part, problem, replace(face, entity=key))

    def _position(self, entity: Any) -> Vector3:
        if isinstance(entity, adsk.fusion.SketchPoint):
            return _metres(entity.worldGeometry)
        if isinstance(entity, (adsk.fusion.BRepVertex, adsk.fusion.ConstructionPoint)):
            return _metres(entity.geometry)
        shape = getattr(entity, "geometry", None)
        if isinstance(shape, (adsk.core.Circle3D, adsk.core.Arc3D)):
            return _metres(shape.center)
        if isinstance(shape, (adsk.core.Sphere, adsk.core.Torus)):
            return _metres(shape.origin)
        raise InputError(
            "The picked entity does not define a point; pick a vertex, circle, sketch point, "
            "construction point, sphere or torus."
        )


def faces_at(
    design: Any, link: str, surface: SurfaceSnapshot, link_of: Mapping[str, str]
) -> list[Any]:
    """Return the faces of a link that have the shape and place of a surface.

    Args:
        design: The design.
        link: Name of the link.
        surface: A cylinder or sphere in the root frame; its length is not compared.
        link_of: Link of each occurrence, by path.
    """
    return [
        face
        for occurrence in every_occurrence(design.rootComponent)
        if link_of.get(occurrence.fullPathName) == link
        for body in occurrence.bRepBodies
        for face in body.faces
        if _has_place(face.geometry, surface)
    ]


def _has_place(shape: Any, surface: SurfaceSnapshot) -> bool:
    kind = adsk.core.Sphere if surface.shape == "sphere" else adsk.core.Cylinder
    if not isinstance(shape, kind) or abs(shape.radius * CM - surface.radius) > _SAME:
        return False
    apart = subtract(_metres(shape.origin), surface.centre)
    if surface.shape == "sphere":
        return math.hypot(*apart) <= _SAME
    axis = shape.axis.x, shape.axis.y, shape.axis.z
    parallel = math.hypot(*cross(axis, surface.axis)) <= _SAME_DIRECTION
    return parallel and math.hypot(*cross(apart, surface.axis)) <= _SAME


def plane(entity: Any) -> Plane:
    """Return the plane of a flat face or construction plane, in the root frame."""
    shape = entity.geometry
    normal = shape.normal.x, shape.normal.y, shape.normal.z
    return Plane(_metres(shape.origin), normal)


def is_center(entity: Any) -> bool:
    """Return whether a point on an entity is at its centre."""
    return isinstance(entity, (adsk.fusion.BRepEdge, adsk.fusion.BRepFace))


def problem_of(entity: Any, occurrence: Any) -> str:
    """Return the reason why the component of an entity is read-only, or an empty string."""
    while occurrence:
        if occurrence.isReferencedComponent:
            return (
                f"{occurrence.name!r} comes from another document and is read-only: right-"
                "click it in the browser and choose Break Link or Edit in Place, or pick a point "
                "of a component of this document."
            )
        occurrence = occurrence.assemblyContext
    return ""


def _metres(p: Any) -> Vector3:
    return p.x * CM, p.y * CM, p.z * CM
