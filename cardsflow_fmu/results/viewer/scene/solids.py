"""Surfaces of boxes, cylinders and ellipsoids."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot.model.robot import Shape
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.core.frames import transform

from .shapes import Triangles

_AROUND, _RINGS = 24, 12
"""Number of mesh vertices around the z axis, and of rings of an ellipsoid from pole to pole."""

_BOX_SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
_BOX_FACES = np.array([face for a, b, c, d in _BOX_SIDES for face in ((a, b, c), (a, c, d))])


def box_triangles(half: FloatArray) -> Triangles:
    """Return the surface of a box at the origin, from half of its edge lengths in [m]."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    return Triangles(corners * half, _BOX_FACES)


def ellipsoid_triangles(half_axes: FloatArray) -> Triangles:
    """Return the surface of an ellipsoid at the origin, from its half axes in [m]."""
    longitude, latitude = np.meshgrid(
        np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False), np.linspace(0.0, np.pi, _RINGS + 1)
    )
    level = np.sin(latitude)
    unit = np.stack([level * np.cos(longitude), level * np.sin(longitude), np.cos(latitude)], -1)
    corners = np.arange(_AROUND * (_RINGS + 1)).reshape(_RINGS + 1, _AROUND)
    a, b = corners[:-1], corners[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return Triangles(half_axes * unit.reshape(-1, 3), faces)


def cylinder_triangles(radius: float, length: float) -> Triangles:
    """Return the surface of a cylinder along z with its centre at the origin, sizes in [m]."""
    angles = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    rim = np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)
    half = np.full((_AROUND, 1), 0.5 * length)
    ends = np.array([[0.0, 0.0, -0.5 * length], [0.0, 0.0, 0.5 * length]])
    vertices = np.concatenate([np.hstack([rim, -half]), np.hstack([rim, half]), ends])
    a = np.arange(_AROUND)
    b, bottom = np.roll(a, -1), np.full(_AROUND, 2 * _AROUND)
    c, d = a + _AROUND, b + _AROUND
    sides = ([a, b, d], [a, d, c], [b, a, bottom], [c, d, bottom + 1])
    return Triangles(vertices, np.concatenate([np.stack(side, axis=1) for side in sides]))


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
