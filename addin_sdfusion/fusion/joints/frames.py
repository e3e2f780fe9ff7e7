"""Frames of joints on each of their two sides, in the root frame.

Fusion reports them as transforms (since November 2024) and as geometry, which may be a joint origin
or null. A transform that is read through a proxy may be the transform of the native joint, in the
frame of the component that contains the joint; this is the case for as-built joints. Geometry has
its origin in the root frame and its axes in the frame of its component. It refers to the first
occurrence of the component that contains the joint.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any

import adsk.fusion

from ...robot.model.pose import Vector3
from ...robot.model.rotations import add
from ...robot.model.transform import Transform
from ..notes import optional
from ..occurrences import Occurrence
from ..units import NEAR, axes_frame, frame, length, position

_EQUAL = 1e-9


@dataclass(frozen=True)
class JointFrames:
    """Frames of a joint on its two sides, in the root frame.

    Attributes:
        one, two: Frame of each side; None if unknown.
        apart: Distance of the sides beyond the motions of the joint, in [m].
    """

    one: Transform | None = None
    two: Transform | None = None
    apart: float = 0.0


@dataclass(frozen=True)
class Place:
    """Occurrences of a joint.

    Attributes:
        occurrence: Occurrence of the component that contains the joint.
        T_first: Pose of the first occurrence of that component.
        one, two: The connected occurrences.
    """

    occurrence: Occurrence
    T_first: Transform
    one: Occurrence
    two: Occurrence


def joint_frames(joint: Any, place: Place, reach: float) -> JointFrames:
    """Return the frames of a joint.

    Args:
        joint: Proxy of the joint in the occurrence.
        reach: Maximum distance of the sides because of slides and offsets, in [m].
    """
    transforms = (
        _transform_in_root(joint, lambda j: j.geometryOneTransform, place),
        _transform_in_root(joint, lambda j: j.geometryTwoTransform, place),
    )
    one, two = transforms
    if one is not None and two is not None:
        return _consistent_frames(one, two, place, reach)
    geometry = (
        optional(lambda: _geometry(joint.geometryOrOriginOne, place.one, place)),
        optional(lambda: _geometry(joint.geometryOrOriginTwo, place.two, place)),
    )
    one, two = (t or g for t, g in zip(transforms, geometry, strict=True))
    apart = 0.0 if one is None or two is None else math.dist(one.p, two.p)
    return JointFrames(one, two, apart if apart > reach + NEAR else 0.0)


def as_built_frame(joint: Any, place: Place) -> Transform | None:
    """Return the frame of an as-built joint; None for a rigid joint."""
    transform = _transform_in_root(joint, lambda j: j.transform, place)
    if transform is not None:
        return transform
    return optional(lambda: _geometry(joint.geometry, place.two, place))


def _transform_in_root(joint: Any, read: Callable[[Any], Any], place: Place) -> Transform | None:
    """Return a transform of a joint in the root frame, or None.

    A transform equal to the transform of the native joint is in the frame of the component.
    """
    T = optional(lambda: _transform(read(joint)))
    native = optional(lambda: joint.nativeObject)
    if T is None or native is None:
        return T
    T_native = optional(lambda: _transform(read(native)))
    return place.occurrence.T.compose(T) if T_native is None or _equal(T, T_native) else T


def _equal(a: Transform, b: Transform) -> bool:
    """Return whether two transforms are equal up to rounding."""
    pairs = zip((*a.R, a.p), (*b.R, b.p), strict=True)
    return all(math.dist(u, v) <= _EQUAL for u, v in pairs)


def _consistent_frames(one: Transform, two: Transform, place: Place, reach: float) -> JointFrames:
    """Return the sides in the root frame, for the first assumed frame in which they coincide.

    Without offset, both sides of a joint coincide. Some versions of Fusion report transforms in the
    frame of the occurrence of the side.
    """
    ones = (one, place.one.T.compose(one))
    twos = (two, place.two.T.compose(two))
    # First assume that both sides are given in the same kind of frame.
    for a, b in (*zip(ones, twos, strict=True), *product(ones, twos)):
        if math.dist(a.p, b.p) <= reach + NEAR:
            return JointFrames(a, b)
    return JointFrames(one, two, math.dist(one.p, two.p))


def _transform(matrix: Any) -> Transform | None:
    return None if matrix is None else frame(matrix)


def _geometry(geometry: Any, side: Occurrence, place: Place) -> Transform | None:
    """Return the frame of a JointGeometry or JointOrigin, whose axes are z, x, y in this order."""
    if geometry is None:
        return None
    origin = adsk.fusion.JointOrigin.cast(geometry)
    if origin is None:
        first = place.T_first.inverse().apply(position(geometry.origin))
        return _axes(geometry, place.occurrence.T.apply(first), side)
    if origin.assemblyContext is None and side.native is not None:
        origin = origin.createForAssemblyContext(side.native)
    T = _axes(origin, position(origin.geometry.origin), side)
    return Transform(T.R, add(T.p, T.rotate(_offsets(origin))))


def _axes(geometry: Any, origin: Vector3, side: Occurrence) -> Transform:
    """Return the frame at an origin in the root frame, with axes given in the component frame."""
    x, y, z = geometry.secondaryAxisVector, geometry.thirdAxisVector, geometry.primaryAxisVector
    axes = axes_frame((0.0, 0.0, 0.0), x, y, z)
    return Transform(side.T.compose(axes).R, origin)


def _offsets(origin: Any) -> Vector3:
    """Return the offsets of a joint origin from its geometry along its axes, in [m]."""
    x, y, z = (
        length(value or 0.0)
        for value in (
            optional(lambda: origin.offsetX.value),
            optional(lambda: origin.offsetY.value),
            optional(lambda: origin.offsetZ.value),
        )
    )
    return x, y, z
