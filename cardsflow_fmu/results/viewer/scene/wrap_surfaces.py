"""Shapes of wrap surfaces."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import WrapSurface
from cardsflow_fmu.utils.arrays import FloatArray

from . import colours
from . import shapes as s

_OPACITY = 0.45
_AROUND, _RINGS = 24, 12
"""Number of mesh vertices of an ellipsoid around its z axis, and of rings from pole to pole."""


def wrap_shape(surface: WrapSurface, T: FloatArray, reach: float) -> s.Shape:
    """Return the translucent shape of a wrap surface; an infinite cylinder has a finite length.

    Args:
        surface: The surface.
        T: Pose in the world, shape (4, 4).
        reach: Reach of the robot, in [m].
    """
    shared, radius, middle = (s.WRAP_SURFACES, surface.name, colours.WRAP), surface.radius, T[:3, 3]
    if surface.half_axes is not None:
        drawn = _ellipsoid(np.array([radius, *surface.half_axes]))
        return s.MeshShape(*shared, T, drawn, lever=reach / 2, opacity=_OPACITY)
    if surface.shape == "sphere":
        return s.Sphere(*shared, middle, radius, opacity=_OPACITY)
    half = 0.5 * min(surface.length, max(4.0 * surface.radius, 0.1 * reach)) * T[:3, 2]
    return s.Cylinder(*shared, middle - half, middle + half, radius, opacity=_OPACITY)


def _ellipsoid(half_axes: FloatArray) -> s.Triangles:
    longitude, latitude = np.meshgrid(
        np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False), np.linspace(0.0, np.pi, _RINGS + 1)
    )
    level = np.sin(latitude)
    unit = np.stack([level * np.cos(longitude), level * np.sin(longitude), np.cos(latitude)], -1)
    corners = np.arange(_AROUND * (_RINGS + 1)).reshape(_RINGS + 1, _AROUND)
    a, b = corners[:-1], corners[1:]
    c, d = np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return s.Triangles(half_axes * unit.reshape(-1, 3), faces)
