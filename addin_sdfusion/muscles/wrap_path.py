"""Path of a muscle over a wrap surface, for the preview drawing and the shown length.

The path is projected onto the plane orthogonal to the axis of the cylinder, or onto the plane
through the centre of the sphere and both points. There it consists of a tangent, a circular arc
and a tangent. Along the axis it has a constant slope.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

from ..robot.model.pose import Vector3, X, Z
from ..robot.model.rotations import add, cross, dot, normalized, perpendicular, subtract
from ..snapshot import SurfaceSnapshot, WrapUse

_STEP = math.radians(6.0)  # angle between points of the arc

Sense = Literal[-1, 1]


class Wrapped(NamedTuple):
    """Path over a surface between two via points.

    Attributes:
        points: Points of the arc, from tangent point to tangent point, in [m].
        length: Exact length from via point to via point, in [m].
    """

    points: list[Vector3]
    length: float


def path_over(start: Vector3, end: Vector3, face: SurfaceSnapshot, use: WrapUse) -> Wrapped | None:
    """Return the path over a surface between two via points; None if there is no contact.

    Args:
        start: Via point before the surface, in the root frame, in [m].
        end: Via point after the surface, in the root frame, in [m].
        use: Side and number of turns of the wrap.
    """
    if use.inside:
        return None
    a, b = subtract(start, face.centre), subtract(end, face.centre)
    axis, sense = normalized(face.axis), use.side
    if face.shape == "sphere":
        normal = normalized(cross(a, b))
        if not any(normal):
            normal = normalized(cross(a, Z if abs(a[2]) < 0.9 * math.hypot(*a) else X))
        turned: Sense = 1 if dot(normal, axis) >= 0.0 else -1
        axis, sense = normal, use.side * turned  # type: ignore[assignment]
    arc = _arc_about_axis(a, b, axis, face.radius, sense, use.turns)
    if arc is None:
        return None
    return Wrapped([add(face.centre, point) for point in arc.points], arc.length)


def _arc_about_axis(
    a: Vector3, b: Vector3, z: Vector3, r: float, side: int, turns: int
) -> Wrapped | None:
    """Return the path about an axis through the origin; None if there is no contact."""
    height_a, height_b = dot(a, z), dot(b, z)
    flat_a, flat_b = perpendicular(a, z), perpendicular(b, z)
    R_a, R_b = math.hypot(*flat_a), math.hypot(*flat_b)
    if min(R_a, R_b) <= r:
        return None
    x = normalized(flat_a)
    y = cross(z, x)
    angle_b = math.atan2(dot(flat_b, y), dot(flat_b, x))  # relative to a
    natural: Sense = 1 if angle_b >= 0.0 else -1
    sense = side or natural
    if turns == 0 and sense == natural and _distance(flat_a, flat_b) >= r:
        return None
    first = sense * math.acos(r / R_a)
    last = angle_b - sense * math.acos(r / R_b)
    sweep = (sense * (last - first)) % (2.0 * math.pi) + 2.0 * math.pi * turns
    before, arc = math.sqrt(R_a * R_a - r * r), r * sweep
    flat_length = before + arc + math.sqrt(R_b * R_b - r * r)
    count = max(math.ceil(sweep / _STEP), 1)
    points: list[Vector3] = []
    for k in range(count + 1):
        angle = first + sense * sweep * k / count
        rise = height_a + (height_b - height_a) * (before + arc * k / count) / flat_length
        u, v = r * math.cos(angle), r * math.sin(angle)
        points.append(tuple(u * x[i] + v * y[i] + rise * z[i] for i in range(3)))  # type: ignore[arg-type]
    return Wrapped(points, math.hypot(flat_length, height_b - height_a))


def _distance(a: Vector3, b: Vector3) -> float:
    """Return the distance of the origin from the line segment between two points."""
    d = subtract(b, a)
    length = dot(d, d)
    t = 0.0 if length == 0.0 else min(max(-dot(a, d) / length, 0.0), 1.0)
    return math.hypot(*(p + t * q for p, q in zip(a, d, strict=True)))
