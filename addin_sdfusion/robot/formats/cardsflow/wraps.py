"""The wraps that cardsflow.xml holds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from ...model.muscle import Muscle, Wrap, WrapSurface

WRAP_TYPES = {"sphere": "SPHERICAL", "cylinder": "CYLINDRICAL"}
"""The via point types of the wrap shapes."""


def held_wraps(muscle: Muscle, surfaces: Mapping[str, WrapSurface]) -> list[Wrap]:
    """The wraps that cardsflow.xml can hold: one a segment, cylinders along the link's z axis.

    Those by other programs' rules and those over ellipsoids it cannot hold.
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
