"""Poses of IMUs in the moving frames of the C core."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from sim_dart.core.arrays import FloatArray, IntArray
from sim_dart.core.frames import moving_frames, transform

from .settings import Imu


class ImuFrames(NamedTuple):
    """Moving frames of IMUs, and poses of the IMUs in these frames.

    Attributes:
        frames: Indices of the moving frames, shape (IMUs,).
        rotations: Rotation matrices, row by row, shape (IMUs, 9).
        positions: Positions, shape (IMUs, 3), in [m].
    """

    frames: IntArray
    rotations: FloatArray
    positions: FloatArray


def imu_frames(robot: Robot, imus: Sequence[Imu]) -> ImuFrames:
    """Return the moving frame of each IMU, and its rotation and position in this frame.

    Raises:
        InputError: An IMU is on a link that does not move.
        UnknownNameError: A link does not exist.
    """
    _, places = moving_frames(robot)
    frames, rotations, positions = [], [], []
    for imu in imus:
        if imu.link not in places:
            raise UnknownNameError("link", imu.link, list(places))
        place = places[imu.link]
        if place.frame < 0:
            raise InputError(
                f"an IMU on {imu.link!r} measures nothing, because the link does not move"
            )
        T = place.T_frame_link @ transform(imu.pose)
        frames.append(place.frame)
        rotations.append(T[:3, :3])
        positions.append(T[:3, 3])
    return ImuFrames(
        np.array(frames, dtype=np.int32),
        np.array(rotations).reshape(-1, 9),
        np.array(positions).reshape(-1, 3),
    )
