"""Wraps that cardsflow.xml can hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from ...model.muscle import Muscle, Wrap, WrapSurface

WRAP_TYPES = {"sphere": "SPHERICAL", "cylinder": "CYLINDRICAL"}
"""Via point types of the wrap shapes."""


def supported_wraps(muscle: Muscle, surfaces: Mapping[str, WrapSurface]) -> list[Wrap]:
    """Return the wraps that cardsflow.xml can hold.

    These are single wraps on a segment, over spheres and over cylinders along the link's z axis.
    Wraps by the rules of other programs and over ellipsoids are not supported.
    """
    counts = Counter(wrap.segment for wrap in muscle.wraps)
    return [
        wrap
        for wrap in muscle.wraps
        if counts[wrap.segment] == 1
        and wrap.rule == "taut"
        and surfaces[wrap.surface].shape in WRAP_TYPES
        and (surfaces[wrap.surface].shape == "sphere" or not any(surfaces[wrap.surface].pose.rpy))
    ]
