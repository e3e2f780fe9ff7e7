"""Picks in Fusion as points and surfaces of the table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import adsk.core
import adsk.fusion

from ...fusion.units import CM
from ...muscles.mirror import Plane
from ...robot.errors import InputError
from ...robot.model.pose import Vector3
from ...snapshot import SurfaceSnapshot
from .editor import HANDLE, Pick


class Picks:
    """The entities that were clicked, by handle."""

    def __init__(self) -> None:
        self._entities: dict[str, Any] = {}

    def entity(self, handle: str) -> Any:
        """What was clicked; None if that is a construction point, or nothing was."""
        return self._entities.get(handle)

    def point(self, entity: Any, key_of: Callable[[Any], str]) -> Pick:
        """Return a click on something that has a point.

        Args:
            entity: As selected: a proxy in the root's context, or of the root itself.
            key_of: What the snapshot calls a construction point.

        Raises:
            InputError: It has no point; the message says what may be clicked.
        """
        center = self._position(entity)
        occurrence = entity.assemblyContext
        path = occurrence.fullPathName if occurrence else ""
        foreign = bool(problem_of(entity, occurrence))  # its place is kept in this design
        if isinstance(entity, adsk.fusion.ConstructionPoint) and not foreign:
            return Pick(center, path, key_of(entity), f"Point {entity.name!r}")
        handle = f"{HANDLE}{len(self._entities)}"
        self._entities[handle] = entity
        part = f"What you picked in {occurrence.name!r}" if occurrence else "What you picked"
        return Pick(center, path, handle, part)

    def surface(self, entity: Any, key_of: Callable[[Any], str]) -> Pick:
        """Return a click on a cylinder or sphere.

        Raises:
            InputError: It is neither.
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
            raise InputError("Muscles wrap over cylinders and spheres only; pick such a face.")
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
            "Pick a vertex, circle, sketch point, construction point, sphere or torus: what you "
            "picked has no point of its own."
        )


def plane(entity: Any) -> Plane:
    """Return the plane of a flat face or construction plane, in the root frame."""
    shape = entity.geometry
    normal = shape.normal.x, shape.normal.y, shape.normal.z
    return Plane(_metres(shape.origin), normal)


def is_center(entity: Any) -> bool:
    """Return whether a construction point on an entity is at its centre."""
    return isinstance(entity, (adsk.fusion.BRepEdge, adsk.fusion.BRepFace))


def problem_of(entity: Any, occurrence: Any) -> str:
    """Why nothing can be stored where the entity is; empty if it can."""
    while occurrence:
        if occurrence.isReferencedComponent:
            return (
                f"{occurrence.name!r} comes from another document and is read-only here: right-"
                "click it in the browser and choose Break Link or Edit in Place, or pick a point "
                "of a component of this document."
            )
        occurrence = occurrence.assemblyContext
    return ""


def _metres(p: Any) -> Vector3:
    return p.x * CM, p.y * CM, p.z * CM
