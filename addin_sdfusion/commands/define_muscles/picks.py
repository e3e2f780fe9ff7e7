"""Conversion of entities picked in Fusion to points and surfaces."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import adsk.core
import adsk.fusion

from ...fusion.occurrences import readable_occurrences
from ...fusion.units import CM, direction, position
from ...muscles.mirror import Plane
from ...robot.errors import InputError
from ...robot.model.pose import Vector3, X
from ...robot.model.rotations import add, cross, normalized, perpendicular, scale, subtract
from ...snapshot import SurfaceSnapshot
from .entities import Entities
from .model.picks import Pick

_SAME = 1e-5  # [m]
_SAME_DIRECTION = 1e-4  # [rad]
_CLICK = 1e-3
"""Maximum distance of a clicked position from its entity, in [m]."""
_FACET = 0.02
"""Maximum distance from a curved face, which Fusion draws with facets, as a share of its radius."""


def picked_point(
    entity: Any, entities: Entities, click: Any = None, use_centre: bool = True
) -> Pick:
    """Return the pick of a point.

    Args:
        entity: The selected entity: a proxy in the context of the root, or an entity of it.
        entities: Known entities, to which the entity is added.
        click: Clicked position in the root frame, a Point3D; None if unknown.
        use_centre: Whether a circle, sphere or torus means its centre instead of the clicked
            position.

    Raises:
        InputError: The entity does not define a point; the message lists valid entities.
    """
    defined = _defined_position(entity, use_centre)
    occurrence = entity.assemblyContext
    path = occurrence.fullPathName if occurrence else ""
    label = f"What you picked in {occurrence.name!r}" if occurrence else "What you picked"
    if defined is None:
        return Pick(_clicked_position(entity, click), path, "", label)
    read_only = bool(problem_of(entity, occurrence))  # stored in the open design
    if isinstance(entity, adsk.fusion.ConstructionPoint) and not read_only:
        return Pick(defined, path, entities.point_key(entity), f"Point {entity.name!r}")
    return Pick(defined, path, entities.handle(entity), label)


def picked_surface(entity: Any, entities: Entities) -> Pick:
    """Return the pick of a cylinder or sphere.

    Raises:
        InputError: The face is not a cylinder or sphere.
    """
    shape = entity.geometry
    occurrence = entity.assemblyContext
    path = occurrence.fullPathName if occurrence else ""
    if isinstance(shape, adsk.core.Sphere):
        face = SurfaceSnapshot(path, "sphere", shape.radius * CM, position(shape.origin))
    elif isinstance(shape, adsk.core.Cylinder):
        axis, centre = direction(shape.axis), position(shape.origin)
        face = SurfaceSnapshot(path, "cylinder", shape.radius * CM, centre, axis)
    else:
        raise InputError("Muscles can wrap only over cylinders and spheres; pick such a face.")
    key = entities.face_key(entity)
    label, problem = f"The face of {entity.body.name!r}", problem_of(entity, occurrence)
    return Pick(face.centre, path, key, label, problem, replace(face, entity=key))


def _defined_position(entity: Any, use_centre: bool) -> Vector3 | None:
    """Return the position of a point or centre; None for a position on an edge or face."""
    if isinstance(entity, adsk.fusion.SketchPoint):
        return position(entity.worldGeometry)
    if isinstance(entity, (adsk.fusion.BRepVertex, adsk.fusion.ConstructionPoint)):
        return position(entity.geometry)
    shape = getattr(entity, "geometry", None)
    if use_centre and isinstance(shape, (adsk.core.Circle3D, adsk.core.Arc3D)):
        return position(shape.center)
    if use_centre and isinstance(shape, (adsk.core.Sphere, adsk.core.Torus)):
        return position(shape.origin)
    return None


def _clicked_position(entity: Any, click: Any) -> Vector3:
    """Return the clicked position, moved onto the exact surface or line.

    Raises:
        InputError: The position is unknown, or it is not on the entity, such as the position of a
            window selection.
    """
    box = entity.body.boundingBox if is_on_body(entity) else None
    if click is None or box is None:
        raise InputError(
            "The picked entity does not define a point; pick a vertex, circle, sketch point, "
            "construction point, sphere or torus, or click on an edge or face."
        )
    clicked, corners = position(click), (position(box.minPoint), position(box.maxPoint))
    place = _nearest(entity.geometry, clicked)
    is_in_box = all(
        low - _CLICK <= at <= high + _CLICK
        for low, at, high in zip(corners[0], place, corners[1], strict=True)
    )
    radius = getattr(entity.geometry, "radius", 0.0) * CM
    if not is_in_box or math.dist(place, clicked) > max(_CLICK, _FACET * radius):
        raise InputError(
            f"The position of the click on {entity.body.name!r} is unknown; click on the edge or "
            "face in the canvas."
        )
    return place


def _nearest(shape: Any, place: Vector3) -> Vector3:
    """Return the nearest position on a plane, cylinder, sphere or line; else the same position."""
    if isinstance(shape, adsk.core.Plane):
        origin, normal = position(shape.origin), direction(shape.normal)
        return add(origin, perpendicular(subtract(place, origin), normal))
    if isinstance(shape, adsk.core.Line3D):
        start, end = position(shape.startPoint), position(shape.endPoint)
        line = normalized(subtract(end, start))
        return subtract(place, perpendicular(subtract(place, start), line))
    if not isinstance(shape, (adsk.core.Cylinder, adsk.core.Sphere)):
        return place
    across = subtract(place, position(shape.origin))
    if isinstance(shape, adsk.core.Cylinder):
        across = perpendicular(across, direction(shape.axis))
    outward = normalized(across) if any(across) else X  # all directions are equal
    return add(subtract(place, across), scale(shape.radius * CM, outward))


def faces_at(
    design: Any, link: str, surface: SurfaceSnapshot, link_of: Mapping[str, str]
) -> list[Any]:
    """Return the faces of a link that have the shape and place of a surface.

    Args:
        surface: A cylinder or sphere in the root frame; its length is not compared.
        link_of: Link of each occurrence, by path.
    """
    return [
        face
        for path, occurrence in readable_occurrences(design.rootComponent).items()
        if path and link_of.get(path) == link
        for body in occurrence.native.bRepBodies
        for face in body.faces
        if _has_place(face.geometry, surface)
    ]


def _has_place(shape: Any, surface: SurfaceSnapshot) -> bool:
    kind = adsk.core.Sphere if surface.shape == "sphere" else adsk.core.Cylinder
    if not isinstance(shape, kind) or abs(shape.radius * CM - surface.radius) > _SAME:
        return False
    apart = subtract(position(shape.origin), surface.centre)
    if surface.shape == "sphere":
        return math.hypot(*apart) <= _SAME
    axis = direction(shape.axis)
    parallel = math.hypot(*cross(axis, surface.axis)) <= _SAME_DIRECTION
    return parallel and math.hypot(*cross(apart, surface.axis)) <= _SAME


def plane(entity: Any) -> Plane:
    """Return the plane of a flat face or construction plane, in the root frame."""
    shape = entity.geometry
    return Plane(position(shape.origin), direction(shape.normal))


def is_on_body(entity: Any) -> bool:
    """Return whether an entity is an edge or face, whose point is at its centre."""
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
