"""Colours of a scene, and the colour ramp of tensions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cardsflow_fmu.utils.arrays import FloatArray

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
    (36, 44, 148),
    (128, 52, 172),
    (196, 64, 136),
    (232, 112, 72),
    (246, 178, 40),
)
"""Evenly spaced colours from minimum to maximum tension: dark blue to yellow.

The lightness increases, so that the colours also differ for people with a colour vision deficiency.
"""


def tension_colour(tension: float, low: float, high: float) -> Colour:
    """Return the colour of a muscle.

    Args:
        tension: Tension, in [N].
        low: Tension at the first colour of the ramp, in [N].
        high: Tension at the last colour of the ramp, in [N].
    """
    red, green, blue = tension_colours(np.array([tension]), low, high)[0].tolist()
    return red, green, blue


def tension_colours(tensions: FloatArray, low: float, high: float) -> NDArray[np.int64]:
    """Return the colours of a muscle at K times, shape (K, 3)."""
    parts = (tensions - low) / (high - low) if high > low else np.zeros(len(tensions))
    is_finite = np.isfinite(tensions)
    at = np.clip(np.where(is_finite, parts, 0.0), 0.0, 1.0)
    ramp = np.array(RAMP)
    places = np.linspace(0.0, 1.0, len(RAMP))
    colours = np.stack([np.interp(at, places, channel) for channel in ramp.T], axis=1)
    colours[~is_finite] = SLACK
    rounded: NDArray[np.int64] = np.rint(colours).astype(np.int64)
    return rounded
