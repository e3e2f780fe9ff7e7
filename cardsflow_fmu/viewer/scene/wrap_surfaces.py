"""Wrap surfaces as shapes."""

from __future__ import annotations

from addin_sdfusion.robot import WrapSurface
from cardsflow_fmu.utils.arrays import FloatArray

from . import colours
from . import shapes as s


def wrap_shape(surface: WrapSurface, T: FloatArray, reach: float) -> s.Shape:
    """A wrap surface as something to see through; a cylinder without ends is cut.

    Args:
        surface: The surface.
        T: Its pose in the world, shape (4, 4).
        reach: Of the robot, in [m].
    """
    name, opacity = f"wrap surfaces/{surface.name}", 0.45
    if surface.shape == "sphere":
        return s.Sphere(
            name=name,
            group=s.WRAP_SURFACES,
            colour=colours.WRAP,
            opacity=opacity,
            centre=T[:3, 3],
            radius=surface.radius,
        )
    half = 0.5 * min(surface.length, max(4.0 * surface.radius, 0.1 * reach)) * T[:3, 2]
    return s.Cylinder(
        name=name,
        group=s.WRAP_SURFACES,
        colour=colours.WRAP,
        opacity=opacity,
        start=T[:3, 3] - half,
        end=T[:3, 3] + half,
        radius=surface.radius,
    )
