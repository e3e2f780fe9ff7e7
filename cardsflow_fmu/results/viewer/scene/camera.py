"""Camera view of a whole stage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray

from .stage import Stage

_FLAT = 0.02
_NEAR = 2.0  # maximum distance of objects in view, as multiple of the reach
_FAR = 1.45  # camera distance, in diagonals of the box; from 0.5 / sin(0.36) the box is in view


@dataclass(frozen=True, eq=False)
class CameraView:
    """Camera view of a stage.

    Attributes:
        centre: Centre of all moving parts, in [m].
        eye: Position of the camera, in [m].
        up: Unit vector against gravity.
        floor: Point below all parts, in [m].
        reach: Reach of the stage, in [m].
        right: Horizontal unit vector that points to the right in the view.
    """

    centre: FloatArray
    eye: FloatArray
    up: FloatArray
    floor: FloatArray
    reach: float
    right: FloatArray


def view_of(stage: Stage) -> CameraView:
    """Return a view along the shortest horizontal axis of a stage, slightly from above."""
    low, high = _box_in_view(stage)
    up, centre = stage.up, 0.5 * (low + high)
    level = [axis for axis in np.eye(3) if abs(axis @ up) < 0.9]
    thin = min(level, key=lambda axis: float(axis @ (high - low)))
    thin = thin - (thin @ up) * up
    back = -thin / np.linalg.norm(thin)
    right = np.cross(up, back)
    flat = float(np.abs(thin) @ (high - low)) < _FLAT * stage.reach
    turn, rise = (0.2, 0.14) if flat else (0.5, 0.35)
    direction = back + turn * right + rise * up
    size = max(stage.reach, float(np.linalg.norm(high - low)))
    eye = centre + _FAR * size * direction / np.linalg.norm(direction)
    drop = 0.5 * float(np.abs(up) @ (high - low)) + 0.06 * stage.reach
    floor = centre - drop * up
    if stage.floor is not None:
        floor = np.array([centre[0], centre[1], stage.floor])
    return CameraView(centre, eye, up, floor, stage.reach, right)


def _box_in_view(stage: Stage) -> tuple[FloatArray, FloatArray]:
    """Return two opposite corners of a box around the robot and the objects near it."""
    low, high = stage.box
    middle = 0.5 * (low + high)
    for positions in stage.environment.positions.values():
        near = positions[np.linalg.norm(positions - middle, axis=1) < _NEAR * stage.reach]
        if len(near):
            low, high = np.minimum(low, near.min(axis=0)), np.maximum(high, near.max(axis=0))
    return low, high
