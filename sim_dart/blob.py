"""Robot -> blob: the flat numbers that the C core works on."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot, Vector3

from .core import pack_blob
from .frames import FloatArray, MovingFrame, moving_frames

_MOTION = {"rotation": 0, "translation": 1}


def _unit(axis: Vector3) -> FloatArray:
    """The axis scaled to length 1: files hold rounded ones."""
    unit: FloatArray = np.array(axis) / np.linalg.norm(axis)
    return unit


def _tree_fields(frames: list[MovingFrame]) -> dict[str, ArrayLike]:
    return {
        "parent": [frame.parent for frame in frames],
        "motion": [_MOTION[frame.motion.kind] for frame in frames],
        "coordinate": [frame.coordinate for frame in frames],
        "offset_rotation": [frame.T_parent_frame[:3, :3] for frame in frames],
        "offset_position": [frame.T_parent_frame[:3, 3] for frame in frames],
        "axis": [_unit(frame.motion.axis) for frame in frames],
    }


def compile_blob(robot: Robot) -> bytes:
    """Compile a robot, with its active cable set and operational space.

    Args:
        robot: A valid robot.
    """
    frames, places = moving_frames(robot)
    points = [point for muscle in robot.muscles for point in muscle.via_points]
    tasks = robot.task_frames
    counts = {
        "dofs": len(frames),
        "muscles": len(robot.muscles),
        "points": len(points),
        "tasks": len(tasks),
    }
    return pack_blob(
        counts,
        _tree_fields(frames)
        | {
            "muscle_points": [len(muscle.via_points) for muscle in robot.muscles],
            "point_frame": [places[point.link].frame for point in points],
            "point_position": [places[point.link].point(point.position) for point in points],
            "task_kind": [int(task.is_orientation) for task in tasks],
            "task_frame": [places[task.link].frame for task in tasks],
            "task_rotation": [places[task.link].T_frame_link[:3, :3] for task in tasks],
            "task_position": [places[task.link].point(task.position) for task in tasks],
        },
    )
