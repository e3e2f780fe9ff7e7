"""Where to look from so that a whole stage is seen well."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .scene import Stage
from .shapes import FloatArray

_FLAT = 0.02


@dataclass(frozen=True, eq=False)
class StageView:
    """A stage seen from outside.

    Attributes:
        centre: The middle of all that moves, in [m].
        eye: Where to look from, in [m].
        up: Unit vector against gravity.
        floor: A point below everything, in [m].
        reach: The stage's, in [m].
        aside: Unit vector to the right, as seen from the eye, level.
    """

    centre: FloatArray
    eye: FloatArray
    up: FloatArray
    floor: FloatArray
    reach: float
    aside: FloatArray


def view_of(stage: Stage) -> StageView:
    """Look along the thinnest level side of a stage, a little turned and from above.

    Args:
        stage: What to look at.
    """
    low, high = stage.box
    up, centre = stage.up, 0.5 * (low + high)
    level = [axis for axis in np.eye(3) if abs(axis @ up) < 0.9]
    thin = min(level, key=lambda axis: float(axis @ (high - low)))
    thin = thin - (thin @ up) * up
    back = -thin / np.linalg.norm(thin)
    aside = np.cross(up, back)
    flat = float(np.abs(thin) @ (high - low)) < _FLAT * stage.reach
    turn, rise = (0.2, 0.14) if flat else (0.5, 0.35)
    eye = centre + 1.25 * stage.reach * (back + turn * aside + rise * up)
    drop = 0.5 * float(np.abs(up) @ (high - low)) + 0.06 * stage.reach
    return StageView(centre, eye, up, centre - drop * up, stage.reach, aside)
