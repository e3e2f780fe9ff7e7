"""Transient curves and surfaces, bounding boxes, collections, values and colours of adsk.core."""

from __future__ import annotations

from typing import Any

import numpy as np

from .base import Base, api, new
from .collections_ import Items, listing
from .maths import apply, frame, point, vector, xyz
from .shapes import EdgeShape, FaceShape


def curve_of(edge: EdgeShape, T: np.ndarray) -> Any:
    """The Line3D, Circle3D or Arc3D of an edge, moved by T."""
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
    """The Plane, Cylinder, Sphere or Torus of a face, moved by T."""
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

    curveType = property(lambda self: self._type)


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
    """Part of a circle, from one angle to another about the normal."""

    _type = 1

    @staticmethod
    def createByCenter(
        center: Point3D,  # noqa: F821
        normal: Vector3D,  # noqa: F821
        referenceVector: Vector3D,  # noqa: F821
        radius: float,
        startAngle: float,
        endAngle: float,
    ) -> Arc3D:
        return new(
            Arc3D,
            center=xyz(center),
            normal=xyz(normal),
            reference=xyz(referenceVector),
            radius=float(radius),
            angles=(float(startAngle), float(endAngle)),
        )

    center = property(lambda self: point(self._center))
    normal = property(lambda self: vector(self._normal))
    referenceVector = property(lambda self: vector(self._reference))
    radius = property(lambda self: self._radius)
    startAngle = property(lambda self: self._angles[0])
    endAngle = property(lambda self: self._angles[1])


@api("adsk.core")
class Surface(Base):
    _type = -1

    surfaceType = property(lambda self: self._type)


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

    def getData(self) -> tuple:
        return (True, self.origin, self.axis, self._radius)


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
    majorRadius = property(lambda self: self._major)
    minorRadius = property(lambda self: self._minor)


def bounding_box(points: Any) -> Any:
    """The BoundingBox3D of points, shape (n, 3)."""
    return new(BoundingBox3D, low=np.min(points, axis=0), high=np.max(points, axis=0))


@api("adsk.core")
class BoundingBox3D(Base):
    @staticmethod
    def create(minPoint: Point3D, maxPoint: Point3D) -> BoundingBox3D:  # noqa: F821
        return bounding_box([xyz(minPoint), xyz(maxPoint)])

    minPoint = property(lambda self: point(self._low))
    maxPoint = property(lambda self: point(self._high))


@api("adsk.core")
@listing
class ObjectCollection(Items):
    def _all(self) -> list[Any]:
        return self._items

    @staticmethod
    def create() -> ObjectCollection:
        return new(ObjectCollection, items=[])

    @staticmethod
    def createWithArray(array: list[Base]) -> ObjectCollection:
        return new(ObjectCollection, items=list(array))

    def add(self, item: Base) -> bool:
        self._items.append(item)
        return True

    def clear(self) -> bool:
        self._items.clear()
        return True

    def contains(self, item: Base) -> bool:
        return item in self._items

    def asArray(self) -> list:
        return list(self._items)

    def removeByIndex(self, index: int) -> bool:
        if not 0 <= index < len(self._items):
            return False
        del self._items[index]
        return True

    def removeByItem(self, item: Base) -> bool:
        if item not in self._items:
            return False
        self._items.remove(item)
        return True


@api("adsk.core")
class ValueInput(Base):
    @staticmethod
    def createByReal(realValue: float) -> ValueInput:
        return new(ValueInput, kind=1, value=float(realValue))

    @staticmethod
    def createByString(stringValue: str) -> ValueInput:
        return new(ValueInput, kind=0, value=stringValue)

    @staticmethod
    def createByBoolean(booleanValue: bool) -> ValueInput:
        return new(ValueInput, kind=3, value=booleanValue)

    valueType = property(lambda self: self._kind)
    realValue = property(lambda self: self._value if self._kind == 1 else 0.0)
    stringValue = property(lambda self: self._value if self._kind == 0 else "")
    booleanValue = property(lambda self: self._value if self._kind == 3 else False)


@api("adsk.core")
class Color(Base):
    """Four numbers from 0 to 255."""

    @staticmethod
    def create(red: int, green: int, blue: int, opacity: int) -> Color:
        if not all(0 <= value <= 255 for value in (red, green, blue, opacity)):
            raise RuntimeError("3 : invalid argument: colours go from 0 to 255")
        return new(Color, rgba=(red, green, blue, opacity))

    red = property(lambda self: self._rgba[0])
    green = property(lambda self: self._rgba[1])
    blue = property(lambda self: self._rgba[2])
    opacity = property(lambda self: self._rgba[3])

    def getColor(self) -> tuple:
        return (True, *self._rgba)
