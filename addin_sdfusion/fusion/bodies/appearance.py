"""Colours of bodies from their appearances."""

from __future__ import annotations

from typing import Any, NamedTuple

import adsk.core

from ..notes import optional
from ..units import finite

_IDS = ("opaque_albedo", "metal_f0", "surface_albedo", "layered_diffuse", "transparent_color")
"""Colour properties of appearances by their type; otherwise the first colour is used."""


class BodyAppearance(NamedTuple):
    """Visual appearance of a body.

    Attributes:
        color: Colour as `#rrggbb`; None if unknown.
        opacity: Opacity from 0 to 1.
        appearance: Name of the appearance; empty if not specified.
    """

    color: str | None = None
    opacity: float = 1.0
    appearance: str = ""


def read_appearance(body: Any) -> BodyAppearance:
    """Return the visual appearance of a body."""
    opacity = optional(lambda: min(max(finite(body.visibleOpacity), 0.0), 1.0))
    appearance = optional(lambda: body.appearance)
    if appearance is None:
        return BodyAppearance(opacity=1.0 if opacity is None else opacity)
    name = optional(lambda: str(appearance.name)) or ""
    return BodyAppearance(
        optional(lambda: _color(appearance)), 1.0 if opacity is None else opacity, name
    )


def _color(appearance: Any) -> str | None:
    colors: dict[str, Any] = {}
    for each in appearance.appearanceProperties:
        colored = adsk.core.ColorProperty.cast(each)
        if colored is not None and colored.value is not None:
            colors[str(colored.id)] = colored.value
    value = next((colors[i] for i in _IDS if i in colors), next(iter(colors.values()), None))
    return None if value is None else f"#{value.red:02x}{value.green:02x}{value.blue:02x}"
