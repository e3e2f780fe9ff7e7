"""Frames of a joint as given by each of its two sides.

Fusion gives them twice: as transforms, since November 2024, which outlive broken geometry, and as
geometry, which may be a joint origin or null. Both are read through the joint's proxy, so they
should be in the root frame. In which frame they really are is not documented, and others have met
each of: the root's, that of the component which holds the joint, that of the occurrence which the
geometry belongs to. A joint without offset has both sides in one point; that decides.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import adsk.fusion

from ...robot.model.pose import Vector3
from ...robot.model.rotations import add
from ...robot.model.transform import Transform
from ..notes import optional
from ..occurrences import Occurrence
from ..units import NEAR, axes_frame, direction, distance, frame, length, near, position


@dataclass(frozen=True)
class JointFrames:
    """The joint's frame as its sides have it, in the root frame.

    Attributes:
        one, two: None where Fusion does not say.
        apart: How far the sides are apart beyond what the joint allows, in [m].
    """

    one: Transform | None = None
    two: Transform | None = None
    apart: float = 0.0


def joint_frames(
    joint: Any, occurrence: Occurrence, T_one: Transform, T_two: Transform, reach: float
) -> JointFrames:
    """The frames of a joint.

    Args:
        joint: Its proxy in the occurrence.
        occurrence: Where the component that holds it is.
        T_one: Pose of its first occurrence in the root frame.
        T_two: Pose of its second.
        reach: How far its sides may be apart, because of slides and offsets, in [m].
    """
    geometry = (
        optional(lambda: _geometry(joint.geometryOrOriginOne)),
        optional(lambda: _geometry(joint.geometryOrOriginTwo)),
    )
    transforms = (
        optional(lambda: _transform(joint.geometryOneTransform)),
        optional(lambda: _transform(joint.geometryTwoTransform)),
    )
    best: JointFrames | None = None
    for sides in (transforms, geometry):
        if sides[0] is None or sides[1] is None:
            continue
        found = _agreeing(sides[0], sides[1], occurrence.T, T_one, T_two, reach)
        if found.apart == 0.0:
            return _lifted(found, geometry, occurrence) if sides is transforms else found
        best = best or found
    if best is not None:
        return best
    return JointFrames(transforms[0] or geometry[0], transforms[1] or geometry[1])


def as_built_frame(joint: Any, occurrence: Occurrence) -> Transform | None:
    """The one frame of an as-built joint; None where there is none, as of a rigid one."""
    geometry = optional(lambda: _geometry(joint.geometry))
    transform = optional(lambda: _transform(joint.transform))
    if transform is None:
        return geometry
    return _lifted(JointFrames(None, transform), (None, geometry), occurrence).two


def _agreeing(
    one: Transform, two: Transform, T: Transform, T_one: Transform, T_two: Transform, reach: float
) -> JointFrames:
    """The sides in the root frame, under the first reading under which they meet."""
    ones = [one, T_one.compose(one), T.compose(one)]
    twos = [two, T_two.compose(two), T.compose(two)]
    # Both in the same frame first: one side's frame is the best guess of the other's.
    pairs = [*zip(ones, twos, strict=True), *product(ones, twos)]
    for a, b in pairs:
        if distance(a.p, b.p) <= reach + NEAR:
            return JointFrames(a, b)
    return JointFrames(one, two, distance(one.p, two.p))


def _lifted(
    found: JointFrames, geometry: tuple[Transform | None, Transform | None], occurrence: Occurrence
) -> JointFrames:
    """The same, out of the frame of the component that holds the joint if it is given in that.

    There both sides meet too; but the geometry, which is known to be in the root frame when it is
    read through a proxy, is then elsewhere.
    """
    for side, other in ((found.one, geometry[0]), (found.two, geometry[1])):
        if side is None or other is None or near(side.p, other.p):
            continue
        if near(occurrence.T.apply(side.p), other.p):
            one, two = (
                None if f is None else occurrence.T.compose(f) for f in (found.one, found.two)
            )
            return JointFrames(one, two)
    return found


def _transform(matrix: Any) -> Transform | None:
    return None if matrix is None else frame(matrix)


def _geometry(geometry: Any) -> Transform | None:
    """The frame of a JointGeometry or a JointOrigin, whose own axes are z, x, y in this order."""
    if geometry is None:
        return None
    x, y, z = geometry.secondaryAxisVector, geometry.thirdAxisVector, geometry.primaryAxisVector
    origin = adsk.fusion.JointOrigin.cast(geometry)
    if origin is None:
        return axes_frame(position(geometry.origin), x, y, z)
    transform = optional(lambda: _transform(origin.transform))
    if transform is not None:
        return transform
    return axes_frame(_offset(origin, position(origin.geometry.origin), x, y, z), x, y, z)


def _offset(origin: Any, start: Vector3, *axes: Any) -> Vector3:
    """Where a joint origin is: its geometry is without its offsets."""
    offsets = (
        optional(lambda: origin.offsetX.value),
        optional(lambda: origin.offsetY.value),
        optional(lambda: origin.offsetZ.value),
    )
    for value, axis in zip(offsets, axes, strict=True):
        x, y, z = direction(axis)
        s = length(value or 0.0)
        start = add(start, (s * x, s * y, s * z))
    return start
