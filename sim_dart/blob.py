"""Robot -> blob: the flat numbers that the C core works on."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot, Vector3, tension_laws
from addin_sdfusion.robot.tension_laws import law_of

from .core import law_parameters, pack_blob
from .frames import FloatArray, MovingFrame, moving_frames
from .path_fields import path_counts, path_fields

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


def _law_fields(robot: Robot) -> dict[str, ArrayLike]:
    kinds = list(law_parameters())
    values = [tension_laws.law_parameters(muscle.model) for muscle in robot.muscles]
    return {
        "law_kind": [kinds.index(law_of(muscle.model).kind) for muscle in robot.muscles],
        "law_parameter": [number for numbers in values for number in numbers.values()],
    }


def compile_blob(robot: Robot) -> bytes:
    """Compile a robot, with its active cable set and operational space.

    Args:
        robot: A valid robot.
    """
    frames, places = moving_frames(robot)
    tasks = robot.task_frames
    counts = path_counts(robot) | {
        "dofs": len(frames),
        "muscles": len(robot.muscles),
        "tasks": len(tasks),
        "law_parameters": sum(len(law_of(muscle.model).parameters) for muscle in robot.muscles),
    }
    return pack_blob(
        counts,
        _tree_fields(frames)
        | _law_fields(robot)
        | path_fields(robot, places)
        | {
            "task_kind": [int(task.is_orientation) for task in tasks],
            "task_frame": [places[task.link].frame for task in tasks],
            "task_rotation": [places[task.link].T_frame_link[:3, :3] for task in tasks],
            "task_position": [places[task.link].point(task.position) for task in tasks],
        },
    )
