"""Transient curves and surfaces, bounding boxes, collections, values and colours of adsk.core."""

from __future__ import annotations

from typing import Any

import numpy as np

from .base import Base, api, new
from .maths import apply, frame, point, vector, xyz
from .model.shapes import EdgeShape, FaceShape


def curve_of(edge: EdgeShape, T: np.ndarray) -> Any:
    """Return the Line3D, Circle3D or Arc3D of an edge, transformed by T."""
    axis, centre = T[:3, :3] @ edge.axis, apply(T, edge.centre)
    if edge.sweep > 0.0:
        reference = T[:3, :3] @ frame((0.0, 0.0, 0.0), edge.axis)[:3, 0]
        return new(
            Arc3D,
            center=centre,
            normal=axis,
            reference=reference,
            radius=edge.radius,
            angles=(0.0, edge.sweep),
        )
    if edge.radius > 0.0:
        return new(Circle3D, center=centre, normal=axis, radius=edge.radius)
    return new(Line3D, start=centre, end=centre + edge.length * axis)


def surface_of(face: FaceShape, T: np.ndarray) -> Any:
    """Return the Plane, Cylinder, Sphere or Torus of a face, transformed by T."""
    axis, origin = T[:3, :3] @ face.axis, apply(T, face.origin)
    if face.kind == "plane":
        return new(Plane, origin=origin, normal=axis)
    if face.kind == "cylinder":
        return new(Cylinder, origin=origin, axis=axis, radius=face.radius)
    if face.kind == "sphere":
        return new(Sphere, origin=origin, radius=face.radius)
    return new(Torus, origin=origin, axis=axis, major=face.radius, minor=face.minor)


@api("adsk.core")
class Curve3D(Base):
    _type = -1


@api("adsk.core")
class Line3D(Curve3D):
    _type = 0

    @staticmethod
    def create(startPoint: Point3D, endPoint: Point3D) -> Line3D:  # noqa: F821
        return new(Line3D, start=xyz(startPoint), end=xyz(endPoint))

    startPoint = property(lambda self: point(self._start))
    endPoint = property(lambda self: point(self._end))


@api("adsk.core")
class Circle3D(Curve3D):
    _type = 2

    center = property(lambda self: point(self._center))
    normal = property(lambda self: vector(self._normal))
    radius = property(lambda self: self._radius)


@api("adsk.core")
class Arc3D(Curve3D):
    """Circular arc between two angles about the normal."""

    _type = 1

    center = property(lambda self: point(self._center))
    normal = property(lambda self: vector(self._normal))
    radius = property(lambda self: self._radius)


@api("adsk.core")
class Surface(Base):
    _type = -1


@api("adsk.core")
class Plane(Surface):
    _type = 0

    origin = property(lambda self: point(self._origin))
    normal = property(lambda self: vector(self._normal))

    @staticmethod
    def create(origin: Point3D, normal: Vector3D) -> Plane:  # noqa: F821
        return new(Plane, origin=xyz(origin), normal=xyz(normal) / normal.length)


@api("adsk.core")
class Cylinder(Surface):
    _type = 1

    origin = property(lambda self: point(self._origin))
    axis = property(lambda self: vector(self._axis))
    radius = property(lambda self: self._radius)


@api("adsk.core")
class Sphere(Surface):
    _type = 3

    origin = property(lambda self: point(self._origin))
    radius = property(lambda self: self._radius)


@api("adsk.core")
class Torus(Surface):
    _type = 4

    origin = property(lambda self: point(self._origin))
    axis = property(lambda self: vector(self._axis))


def bounding_box(points: Any) -> Any:
    """Return the BoundingBox3D of points, shape (n, 3)."""
    return new(BoundingBox3D, low=np.min(points, axis=0), high=np.max(points, axis=0))


@api("adsk.core")
class BoundingBox3D(Base):
    @staticmethod
    def create(minPoint: Point3D, maxPoint: Point3D) -> BoundingBox3D:  # noqa: F821
        return bounding_box([xyz(minPoint), xyz(maxPoint)])

    minPoint = property(lambda self: point(self._low))
    maxPoint = property(lambda self: point(self._high))


@api("adsk.core")
class Color(Base):
    """Colour with components from 0 to 255."""

    @staticmethod
    def create(red: int, green: int, blue: int, opacity: int) -> Color:
        if not all(0 <= value <= 255 for value in (red, green, blue, opacity)):
            raise RuntimeError("3 : invalid argument: colours go from 0 to 255")
        return new(Color, rgba=(red, green, blue, opacity))

    red = property(lambda self: self._rgba[0])
    green = property(lambda self: self._rgba[1])
    blue = property(lambda self: self._rgba[2])
    opacity = property(lambda self: self._rgba[3])
