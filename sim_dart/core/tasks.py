"""Rows of the task coordinates y in the values of the task frames."""

from __future__ import annotations

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.robot import ANGLES, POSITIONS

_ROWS = {axis: k for axes in (POSITIONS, ANGLES) for k, axis in enumerate(axes)}


def task_rows(robot: Robot) -> list[int]:
    """Return the row of every task coordinate in an array with three rows per task frame."""
    return [3 * k + _ROWS[axis] for k, frame in enumerate(robot.task_frames) for axis in frame.axes]


def point_rows(robot: Robot) -> list[int]:
    """Return the rows of the position task frames in an array with three rows per task frame."""
    frames = enumerate(robot.task_frames)
    return [3 * k + row for k, frame in frames if not frame.is_orientation for row in range(3)]
