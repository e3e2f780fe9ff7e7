"""Wrap faces, in every occurrence."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from operator import eq
from typing import Any, NamedTuple

import adsk.core
import adsk.fusion

from ..muscles.attributes import GROUP, WRAP, stored_surface
from ..robot.finding import Subject
from ..robot.model.pose import Vector3
from ..robot.model.rotations import add, cross, dot, subtract
from ..snapshot import SurfaceSnapshot
from .names import Keys
from .notes import Notes
from .occurrences import Occurrence
from .points import own_attributes
from .units import direction, length, position

_AGAIN = "Pick the face again in Define muscles"
_STROKE = 0.001  # [cm], how far the pieces of a curved edge may be from it


@dataclass(frozen=True)
class _Body:
    """A native body, its component, and its wrap faces with their attributes."""

    native: Any
    name: str
    component: Any
    faces: list[tuple[Any, dict[str, str]]]


class _Extent(NamedTuple):
    """From where to where an edge goes along an axis, in [m]."""

    low: float
    high: float


def read_surfaces(
    design: Any, occurrences: Sequence[Occurrence], keys: Keys, notes: Notes
) -> Iterator[SurfaceSnapshot]:
    """The wrap surfaces of a design, each in every occurrence of its component."""
    subject = Subject("design", "wrap surfaces")
    read = notes.attempt(subject, "attributes", lambda: list(design.findAttributes(GROUP, WRAP)))
    faces = [face for attribute in read or () for face in _faces(attribute, notes)]
    for body in _by_body(faces, subject, notes):
        for occurrence in occurrences:
            if notes.attempt(subject, "component", eq, occurrence.component, body.component):
                yield from _in_occurrence(occurrence, body, keys, notes)


def _faces(attribute: Any, notes: Notes) -> Iterator[Any]:
    """The native face that holds an attribute, if there still is one."""
    subject = Subject("wrap_surface", "?")
    read = notes.attempt(
        subject, "face", lambda: (attribute.parent, attribute.otherParents), todo=_AGAIN
    )
    parent, others = read or (None, None)
    if read is not None and parent is None:
        message = f"the face of a wrap surface is gone from the design: {_AGAIN}"
        notes.warn(subject, "lost-face", message)
    face = adsk.fusion.BRepFace.cast(parent)
    if face is None:
        return
    if others is not None and len(others) > 0:
        message = f"the face of a wrap surface has been split; one part of it counts. {_AGAIN}"
        notes.warn(subject, "split-face", message)
    yield face.nativeObject or face


def _by_body(faces: Iterable[Any], subject: Subject, notes: Notes) -> list[_Body]:
    """Faces by native body; API objects cannot be hashed."""
    found: list[_Body] = []
    for face in faces:
        body = notes.attempt(subject, "body", _body_of, face)
        if body is None:
            continue
        known = next((other for other in found if other.native == body.native), None)
        if known is None:
            found.append(body)
        else:
            known.faces.extend(body.faces)
    return found


def _body_of(face: Any) -> _Body:
    body = face.body.nativeObject or face.body
    return _Body(body, str(body.name), body.parentComponent, [(face, own_attributes(face))])


def _in_occurrence(
    occurrence: Occurrence, body: _Body, keys: Keys, notes: Notes
) -> Iterator[SurfaceSnapshot]:
    """The wrap surfaces of one body in one occurrence."""
    read = []
    for face, held in body.faces:
        subject = Subject("wrap_surface", occurrence.named(body.name))
        pair = notes.attempt(subject, "face", _surface, occurrence, face, todo=_AGAIN)
        if pair is not None:
            own, surface = pair
            use = stored_surface(held, occurrence.path or body.name, notes.findings)
            read.append(((held.get(WRAP, ""), own), replace(surface, use=use)))
    read.sort(key=lambda pair: pair[0])
    for number, (_, surface) in enumerate(read):
        key = keys.key(occurrence, f"{body.name}/face", number)
        yield replace(surface, entity=key)


def _surface(occurrence: Occurrence, face: Any) -> tuple[Vector3, SurfaceSnapshot]:
    """Return a face in an occurrence; first where it is in its component.

    Raises:
        ValueError: It is neither cylinder nor sphere.
    """
    proxy = occurrence.proxy(face)
    sphere, placed = (adsk.core.Sphere.cast(f.geometry) for f in (face, proxy))
    if sphere is not None:
        own = position(sphere.origin)
        centre = occurrence.in_root(position(placed.origin), own)
        radius = length(placed.radius)
        return own, SurfaceSnapshot(occurrence.path, "sphere", radius, centre)
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
    """Return the middle of a cylinder face on its axis, and its length, in the face's own frame."""
    extents = [_edge_extent(edge, origin, axis) for edge in list(face.edges)]
    if not extents:
        raise ValueError("it has no edges, so no length")
    low, high = min(e.low for e in extents), max(e.high for e in extents)
    if not high > low:
        raise ValueError("it has no length")
    along = (low + high) / 2.0
    return add(origin, (along * axis[0], along * axis[1], along * axis[2])), high - low


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
        points = _strokes(edge.evaluator)
    along = [dot(subtract(point, origin), axis) for point in points]
    return _Extent(min(along), max(along))


def _strokes(evaluator: Any) -> list[Vector3]:
    """Points along an edge that is no circle: where a cylinder is cut at an angle or by a face."""
    done, start, end = evaluator.getParameterExtents()
    if done:
        done, points = evaluator.getStrokes(start, end, _STROKE)
    if not done or not points:
        raise ValueError("an edge of it cannot be followed")
    return [position(point) for point in points]
