"""Appearances of bodies with their colours."""

from __future__ import annotations

from typing import Any

from ..base import Base, api, new
from ..collections_ import Items, named
from ..curves import Color


@api("adsk.core")
class Property(Base):
    id = property(lambda self: self._id)
    name = property(lambda self: self._id)


@api("adsk.core")
class FloatProperty(Property):
    value = property(lambda _: 0.5)


@api("adsk.core")
class ColorProperty(Property):
    value = property(lambda self: Color.create(*self._rgb, 255))


@api("adsk.core")
@named
class Properties(Items):
    def _all(self) -> list[Any]:
        gloss, edge = new(FloatProperty, id="surface_roughness"), (0, 0, 0)
        colors = [new(ColorProperty, id="edge_color", rgb=edge)]
        return [gloss, *colors, new(ColorProperty, id="metal_f0", rgb=self._rgb)]


@api("adsk.core")
class Appearance(Base):
    """Appearance with several colour properties."""

    name = property(lambda _: "Steel - Satin")
    appearanceProperties = property(lambda self: new(Properties, rgb=self._rgb))
