"""Boxes, spheres and cylinders that enclose convex hulls."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

from ..robot.model.pose import AXES, Pose, Vector3
from ..robot.model.robot import Shape, ShapeKind
from ..robot.model.rotations import (
    Matrix3,
    add,
    cross,
    dot,
    normalized,
    perpendicular,
    rotate,
    rpy,
    scale,
    subtract,
    transpose,
)

_DIRECTIONS = 5
_PARALLEL = 1e-6
_DIGITS = 6  # number of equal digits of normals of one face


def fit_shape(kind: ShapeKind, nodes: Sequence[float], triangles: Sequence[int]) -> Shape:
    """Return the smallest enclosing shape of a hull that is aligned with its largest faces.

    The centre of a sphere is the centre of the smallest such box. For hulls of boxes, cylinders and
    spheres, the shape is as exact as the triangles.

    Args:
        nodes: x, y, z of every corner, in [m].
        triangles: Three indices of corners per triangle.
    """
    points = [(nodes[i], nodes[i + 1], nodes[i + 2]) for i in range(0, len(nodes), 3)]
    frames = [_to_frame(R, points) for R in _frames(points, triangles)]
    if kind == "cylinder":
        every = [cylinder for frame in frames for cylinder in _cylinders(*frame)]
        return min(every, key=lambda c: c.sizes[0] ** 2 * c.sizes[1])
    R, low, high, _ = min(frames, key=lambda f: math.prod(subtract(f[2], f[1])))
    middle = rotate(R, scale(0.5, add(low, high)))
    if kind == "box":
        return Shape("box", subtract(high, low), Pose(middle, rpy(R)))
    return Shape("sphere", (max(math.dist(middle, p) for p in points),), Pose(middle))


_Frame = tuple[Matrix3, Vector3, Vector3, list[Vector3]]
"""Rotation of a frame, minimum and maximum corner of the points in it, points in it."""


def _to_frame(R: Matrix3, points: Sequence[Vector3]) -> _Frame:
    inverse = transpose(R)
    points_in_frame = [rotate(inverse, p) for p in points]
    xs, ys, zs = zip(*points_in_frame, strict=True)
    return R, (min(xs), min(ys), min(zs)), (max(xs), max(ys), max(zs)), points_in_frame


def _cylinders(R: Matrix3, low: Vector3, high: Vector3, points: list[Vector3]) -> Iterator[Shape]:
    """Yield the enclosing cylinder along each axis of a frame."""
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        middle = scale(0.5, add(low, high))
        radius = max(math.hypot(p[i] - middle[i], p[j] - middle[j]) for p in points)
        rows = transpose(R)
        turned = transpose((rows[i], rows[j], rows[k]))
        pose = Pose(rotate(R, middle), rpy(turned))
        yield Shape("cylinder", (radius, high[k] - low[k]), pose)


def _frames(points: Sequence[Vector3], triangles: Sequence[int]) -> Iterator[Matrix3]:
    """Yield the link frame, and the frames of each pair of normals of the largest faces."""
    yield AXES
    for z, other in combinations(_directions(points, triangles), 2):
        along = perpendicular(other, z)
        if dot(along, along) > _PARALLEL:
            x = normalized(along)
            yield transpose((x, cross(z, x), z))


def _directions(points: Sequence[Vector3], triangles: Sequence[int]) -> list[Vector3]:
    """Return the normals of the largest faces; opposite normals are treated as equal.

    A face may consist of many triangles.
    """
    areas: dict[Vector3, float] = {}
    normals: dict[Vector3, Vector3] = {}
    for t in range(0, len(triangles), 3):
        p, q, r = (points[i] for i in triangles[t : t + 3])
        normal = cross(subtract(q, p), subtract(r, p))
        area = math.sqrt(dot(normal, normal))
        if area == 0.0:
            continue
        x, y, z = scale(1.0 / area, normal)
        near = round(x, _DIGITS) + 0.0, round(y, _DIGITS) + 0.0, round(z, _DIGITS) + 0.0
        key = max(near, scale(-1.0, near))
        areas[key] = areas.get(key, 0.0) + area
        normals.setdefault(key, (x, y, z))
    return [normals[key] for key in sorted(areas, key=lambda k: (-areas[k], k))[:_DIRECTIONS]]
