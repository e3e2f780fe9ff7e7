"""Points of a robot where external loads and wrenches act."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot, UnknownNameError

from .arrays import FloatArray
from .frames import moving_frames


def wrench_points(robot: Robot, wrenched: Sequence[str]) -> tuple[NDArray[np.int32], FloatArray]:
    """Return the points where loads and wrenches act.

    Loads act at the task frames that are points, wrenches at the origins of links. The points of
    the loads are first.

    Args:
        robot: A valid robot.
        wrenched: Names of the links on which external wrenches act.

    Returns:
        Index of the moving frame of each point, shape (k,), -1 for the world; and the positions in
        these frames, shape (k, 3), in [m].

    Raises:
        UnknownNameError: A link does not exist.
    """
    _, places = moving_frames(robot)
    names = [link.name for link in robot.links]
    for link in wrenched:
        if link not in names:
            raise UnknownNameError("link", link, names)
    points = [frame for frame in robot.task_frames if not frame.is_orientation]
    where = [(places[point.link], point.position) for point in points]
    where += [(places[link], (0.0, 0.0, 0.0)) for link in wrenched]
    frames = np.array([place.frame for place, _ in where], dtype=np.int32)
    return frames, np.array([place.point(position) for place, position in where]).reshape(-1, 3)
