"""The colours of a scene, and the ramp that shows tensions."""

from __future__ import annotations

import numpy as np

from .shapes import Colour

LINK: Colour = (168, 174, 184)
JOINT: Colour = (86, 94, 108)
VIA_POINT: Colour = (52, 58, 70)
FORCE: Colour = (232, 140, 20)
MOTOR: Colour = (150, 86, 200)
WRAP: Colour = (110, 190, 150)
CONTACT: Colour = (30, 160, 90)
OBJECT: Colour = (222, 174, 96)
STILL: Colour = (190, 178, 160)
GROUND: Colour = (226, 229, 234)
TRAIL: Colour = (120, 198, 255)
REFERENCE: Colour = (70, 76, 88)
TEXT: Colour = (40, 44, 52)
SLACK: Colour = (150, 60, 60)

RAMP: tuple[Colour, ...] = (
    (40, 92, 214),
    (112, 62, 214),
    (188, 48, 170),
    (232, 52, 96),
    (255, 112, 32),
)
"""From the smallest tension to the largest, evenly spaced: dark to light, blue to orange."""


def tension_colour(tension: float, low: float, high: float) -> Colour:
    """The colour of a muscle.

    Args:
        tension: In [N].
        low: Where the ramp begins, in [N].
        high: Where it ends, in [N].
    """
    if not np.isfinite(tension):
        return SLACK
    part = (tension - low) / (high - low) if high > low else 0.0
    at = float(np.clip(part, 0.0, 1.0)) * (len(RAMP) - 1)
    below = min(int(at), len(RAMP) - 2)
    a, b = np.array(RAMP[below]), np.array(RAMP[below + 1])
    red, green, blue = np.rint(a + (at - below) * (b - a)).astype(int).tolist()
    return red, green, blue
