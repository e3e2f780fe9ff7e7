"""Places of inertial units in the C core's frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from sim_dart.core.arrays import FloatArray, IntArray
from sim_dart.core.frames import moving_frames, transform

from .settings import InertialUnit


class UnitPlaces(NamedTuple):
    """Frames of inertial units, and their poses there.

    Attributes:
        frames: Shape (units,).
        rotations: Row by row, shape (units, 9).
        positions: Shape (units, 3), in [m].
    """

    frames: IntArray
    rotations: FloatArray
    positions: FloatArray


def unit_places(robot: Robot, units: Sequence[InertialUnit]) -> UnitPlaces:
    """Return the frame of each unit, and its rotation and position there.

    Raises:
        InputError: A unit is on a link that does not move.
        UnknownNameError: There is no such link.
    """
    _, places = moving_frames(robot)
    frames, rotations, positions = [], [], []
    for unit in units:
        if unit.link not in places:
            raise UnknownNameError("link", unit.link, list(places))
        place = places[unit.link]
        if place.frame < 0:
            raise InputError(
                f"an IMU on {unit.link!r} measures nothing, because the link does not move"
            )
        T = place.T_frame_link @ transform(unit.pose)
        frames.append(place.frame)
        rotations.append(T[:3, :3])
        positions.append(T[:3, 3])
    return UnitPlaces(
        np.array(frames, dtype=np.int32),
        np.array(rotations).reshape(-1, 9),
        np.array(positions).reshape(-1, 3),
    )
