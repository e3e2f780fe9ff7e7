"""Speeds at which a robot can continue its reference after the loss of a muscle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

POSE, FALL = 0.0, -1.0
"""Speeds of a motion of which only a pose can be held, or not even a pose."""


@dataclass(frozen=True)
class LookAhead:
    """Table of relative speeds of the reference.

    Attributes:
        times: Times of the reference, in [s].
        speeds: For each muscle, the speed with which the other muscles can produce the motion from
            each time on, relative to the reference's own; `POSE` or `FALL` if they cannot.
    """

    times: Sequence[float]
    speeds: Mapping[str, Sequence[float]]
