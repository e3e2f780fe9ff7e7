"""Surfaces of boxes, cylinders and ellipsoids, and convex hulls."""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import Literal

import numpy as np

from addin_sdfusion.robot.model.robot import Shape
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.core.frames import transform

from .shapes import Triangles

_AROUND, _RINGS = 24, 12
"""Number of mesh vertices around the z axis, and of rings of an ellipsoid from pole to pole."""


def box_triangles(half: FloatArray) -> Triangles:
    """Return the surface of a box at the origin, from half of its edge lengths in [m]."""
    return _scaled("box", half)


def ellipsoid_triangles(half_axes: FloatArray) -> Triangles:
    """Return the surface of an ellipsoid at the origin, from its half axes in [m]."""
    return _scaled("ellipsoid", half_axes)


def cylinder_triangles(radius: float, length: float) -> Triangles:
    """Return the surface of a cylinder along z with its centre at the origin, sizes in [m]."""
    return _scaled("cylinder", np.array([radius, radius, 0.5 * length]))


def _scaled(kind: Literal["box", "cylinder", "ellipsoid"], half: FloatArray) -> Triangles:
    unit = _unit_body(kind)
    return Triangles(unit.vertices * half, unit.faces)


@cache
def _unit_body(kind: str) -> Triangles:
    """Return the surface of a body that extends from -1 to 1 along each axis."""
    latitudes = np.linspace(0.0, np.pi, _RINGS + 1) if kind == "ellipsoid" else ()
    rings = [(np.sin(a), np.cos(a)) for a in latitudes] or [(1.0, -1.0), (1.0, 1.0)]
    angles = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    points = [(r * np.cos(a), r * np.sin(a), z) for r, z in rings for a in angles]
    hull = convex_hull(np.array([*product((-1.0, 1.0), repeat=3)] if kind == "box" else points))
    assert hull is not None
    return hull


def shape_triangles(shape: Shape) -> Triangles:
    """Return the surface of a collision shape in the frame of its link."""
    if shape.kind == "box":
        surface = box_triangles(0.5 * np.array(shape.sizes))
    elif shape.kind == "cylinder":
        surface = cylinder_triangles(*shape.sizes)
    else:
        surface = ellipsoid_triangles(np.full(3, shape.sizes[0]))
    T = transform(shape.pose)
    return Triangles(surface.vertices @ T[:3, :3].T + T[:3, 3], surface.faces)


def convex_hull(points: FloatArray) -> Triangles | None:
    """Return the convex hull of points with outward faces; None if they span no volume."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):  # no volume after rounding, or not finite
        return None
    faces = hull.simplices.astype(np.int64)
    a, b, c = (points[faces[:, i]] for i in range(3))
    inwards = np.einsum("fi,fi->f", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inwards] = faces[inwards, ::-1]
    corners, numbers = np.unique(faces, return_inverse=True)
    return Triangles(points[corners], numbers.reshape(faces.shape))
