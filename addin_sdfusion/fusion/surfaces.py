"""Wrap surfaces in every occurrence."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from operator import eq
from typing import Any, NamedTuple

import adsk.core
import adsk.fusion

from ..muscles.attributes import GROUP, WRAP
from ..muscles.stored import stored_surface
from ..robot.finding import Subject
from ..robot.model.pose import Vector3
from ..robot.model.rotations import add, cross, dot, scale, subtract
from ..snapshot import HIDDEN_KEY, SurfaceSnapshot
from .names import Keys
from .notes import Notes
from .occurrences import Occurrence, component_id
from .places import Places
from .points import own_attributes, with_occurrence, without_occurrence
from .units import direction, length, position

_AGAIN = "Pick the face again in Define muscles"
_STROKE = 0.001  # [cm], tolerance of the polyline of a curved edge


@dataclass(frozen=True)
class _Body:
    """A native body with its component and its wrap faces with attributes."""

    native: Any
    name: str
    component: Any
    faces: list[tuple[Any, dict[str, str]]]


class _Extent(NamedTuple):
    """Minimum and maximum coordinate of an edge along an axis, in [m]."""

    low: float
    high: float


def read_surfaces(
    design: Any, occurrences: Sequence[Occurrence], keys: Keys, places: Places, notes: Notes
) -> Iterator[SurfaceSnapshot]:
    """Yield the wrap surfaces of a design in every occurrence."""
    subject = Subject("design", "wrap surfaces")
    read = notes.attempt(subject, "attributes", lambda: list(design.findAttributes(GROUP, WRAP)))
    faces = [face for attribute in read or () for face in _faces(attribute, notes)]
    for body in _by_body(faces, subject, notes):
        with_body = [
            occurrence
            for occurrence in occurrences
            if notes.attempt(subject, "component", eq, occurrence.component, body.component)
        ]
        if not with_body:
            yield from _hidden(body, notes)
        for occurrence in with_body:
            yield from _in_occurrence(occurrence, body, keys, places, notes)


def _hidden(body: _Body, notes: Notes) -> Iterator[SurfaceSnapshot]:
    """Yield the wrap surfaces of a body whose component has no occurrence, as lost surfaces."""
    component = body.component
    for number, (_, attributes) in enumerate(body.faces):
        use = stored_surface(attributes, body.name, notes.findings)
        if use is not None:
            use, why = without_occurrence(use, component)
            key = f"{HIDDEN_KEY}{component_id(component)}/{component.name}/{body.name}/face{number}"
            yield SurfaceSnapshot("", "sphere", 0.0, (0.0, 0.0, 0.0), entity=key, use=use, lost=why)


def _faces(attribute: Any, notes: Notes) -> Iterator[Any]:
    """Yield the native face with an attribute, if it still exists."""
    subject = Subject("wrap_surface", "?")
    read = notes.attempt(
        subject, "face", lambda: (attribute.parent, attribute.otherParents), todo=_AGAIN
    )
    parent, others = read or (None, None)
    if read is not None and parent is None:
        message = f"the face of a wrap surface does not exist any more: {_AGAIN}"
        notes.warn(subject, "lost-face", message)
    face = adsk.fusion.BRepFace.cast(parent)
    if face is None:
        return
    if others is not None and len(others) > 0:
        message = f"the face of a wrap surface was split; only one part of it is used. {_AGAIN}"
        notes.warn(subject, "split-face", message)
    yield face.nativeObject or face


def _by_body(faces: Iterable[Any], subject: Subject, notes: Notes) -> list[_Body]:
    """Return faces grouped by native body, in lists because API objects are not hashable."""
    bodies: list[_Body] = []
    for face in faces:
        body = notes.attempt(subject, "body", _body_of, face)
        if body is None:
            continue
        same_body = next((other for other in bodies if other.native == body.native), None)
        if same_body is None:
            bodies.append(body)
        else:
            same_body.faces.extend(body.faces)
    return bodies


def _body_of(face: Any) -> _Body:
    body = face.body.nativeObject or face.body
    return _Body(body, str(body.name), body.parentComponent, [(face, own_attributes(face))])


def _in_occurrence(
    occurrence: Occurrence, body: _Body, keys: Keys, places: Places, notes: Notes
) -> Iterator[SurfaceSnapshot]:
    """Yield the wrap surfaces of one body in one occurrence."""
    faces = []
    for face, attributes in body.faces:
        subject = Subject("wrap_surface", occurrence.named(body.name))
        pair = notes.attempt(subject, "face", _surface, occurrence, face, todo=_AGAIN)
        if pair is not None:
            point, surface = pair
            use = stored_surface(attributes, occurrence.path or body.name, notes.findings)
            if use is not None:
                subject = Subject("wrap_surface", use.name)
                use, lost = with_occurrence(use, subject, occurrence.path, places, notes)
                surface = replace(surface, use=use, lost=lost)
            faces.append(((attributes.get(WRAP, ""), point), surface))
    faces.sort(key=lambda pair: pair[0])
    for number, (_, surface) in enumerate(faces):
        key = keys.key(occurrence, f"{body.name}/face", number)
        yield replace(surface, entity=key)


def _surface(occurrence: Occurrence, face: Any) -> tuple[Vector3, SurfaceSnapshot]:
    """Return the position of a face in its component, and the face in an occurrence."""
    proxy = occurrence.proxy(face)
    sphere, placed = (adsk.core.Sphere.cast(f.geometry) for f in (face, proxy))
    if sphere is not None:
        centre_in_component = position(sphere.origin)
        centre = occurrence.in_root(position(placed.origin), centre_in_component)
        radius = length(placed.radius)
        return centre_in_component, SurfaceSnapshot(occurrence.path, "sphere", radius, centre)
    cylinder, placed = (adsk.core.Cylinder.cast(f.geometry) for f in (face, proxy))
    if cylinder is None:
        raise ValueError("it is neither a cylinder nor a sphere")
    middle, size = _extent(face, position(cylinder.origin), direction(cylinder.axis))
    surface = SurfaceSnapshot(
        occurrence.path,
        "cylinder",
        length(placed.radius),
        occurrence.T.apply(middle),
        occurrence.T.rotate(direction(cylinder.axis)),
        size,
    )
    return middle, surface


def _extent(face: Any, origin: Vector3, axis: Vector3) -> tuple[Vector3, float]:
    """Return the centre of a cylinder on its axis, and its length, in the frame of the face."""
    extents = [_edge_extent(edge, origin, axis) for edge in list(face.edges)]
    if not extents:
        raise ValueError("it has no edges and therefore no length")
    low, high = min(e.low for e in extents), max(e.high for e in extents)
    if not high > low:
        raise ValueError("it has no length")
    return add(origin, scale((low + high) / 2.0, axis)), high - low


def _edge_extent(edge: Any, origin: Vector3, axis: Vector3) -> _Extent:
    curve = edge.geometry
    circle = adsk.core.Circle3D.cast(curve)
    if circle is not None:
        middle = dot(subtract(position(circle.center), origin), axis)
        reach = length(circle.radius) * math.hypot(*cross(direction(circle.normal), axis))
        return _Extent(middle - reach, middle + reach)
    line = adsk.core.Line3D.cast(curve)
    if line is not None:
        points = [position(line.startPoint), position(line.endPoint)]
    else:
        points = _edge_points(edge.evaluator)
    along = [dot(subtract(point, origin), axis) for point in points]
    return _Extent(min(along), max(along))


def _edge_points(evaluator: Any) -> list[Vector3]:
    """Return points along an edge that is not a circle."""
    done, start, end = evaluator.getParameterExtents()
    if done:
        done, points = evaluator.getStrokes(start, end, _STROKE)
    if not done or not points:
        raise ValueError("one of its edges cannot be evaluated")
    return [position(point) for point in points]
