"""Shapes of wrap surfaces."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import WrapSurface
from cardsflow_fmu.utils.arrays import FloatArray

from . import colours
from . import shapes as s
from .solids import ellipsoid_triangles

_OPACITY = 0.45


def wrap_shape(surface: WrapSurface, T: FloatArray, reach: float) -> s.Shape:
    """Return the translucent shape of a wrap surface; an infinite cylinder has a finite length.

    Args:
        T: Pose in the world, shape (4, 4).
        reach: Reach of the robot, in [m].
    """
    shared, radius, middle = (s.WRAP_SURFACES, surface.name, colours.WRAP), surface.radius, T[:3, 3]
    if surface.half_axes is not None:
        drawn = ellipsoid_triangles(np.array([radius, *surface.half_axes]))
        return s.MeshShape(*shared, T, drawn, lever=reach / 2, opacity=_OPACITY)
    if surface.shape == "sphere":
        return s.Sphere(*shared, middle, radius, opacity=_OPACITY)
    half = 0.5 * min(surface.length, max(4.0 * surface.radius, 0.1 * reach)) * T[:3, 2]
    return s.Cylinder(*shared, middle - half, middle + half, radius, opacity=_OPACITY)
