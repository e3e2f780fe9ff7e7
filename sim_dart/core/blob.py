"""Compilation of a robot to a blob, the flat array of numbers that the C core reads."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Inertia, Robot, Vector3
from addin_sdfusion.robot.model import muscle_laws
from addin_sdfusion.robot.model.laws import MUSCLE_LAWS
from addin_sdfusion.robot.model.muscle_laws import law_of

from .arrays import FloatArray
from .frames import MovingFrame, Place, moving_frames
from .library import pack_blob
from .loop_fields import closures, loop_fields
from .path_fields import path_counts, path_fields
from .supported_features import require_supported_features
from .variables import robot_variables, variable_counts, variable_fields

Fields = dict[str, ArrayLike]

_MOTION = {"rotation": 0, "translation": 1}


def _unit(axis: Vector3) -> FloatArray:
    """Return the axis scaled to length 1. Files contain rounded unit vectors."""
    unit: FloatArray = np.array(axis) / np.linalg.norm(axis)
    return unit


def composite_inertias(
    robot: Robot, frames: list[MovingFrame], places: dict[str, Place]
) -> list[Inertia]:
    """Return the inertia of every moving frame, then of the links fixed to the world."""
    bodies: list[list[Inertia]] = [[] for _ in [*frames, None]]
    for link in robot.links:
        place = places[link.name]
        bodies[place.frame].append(place.inertia(link.inertia))
    return [Inertia.of_bodies(each) for each in bodies]


def fixed_energy(robot: Robot) -> float:
    """Return the potential energy of the weight of fixed links, in [J]; 0 at the world's origin."""
    fixed = composite_inertias(robot, *moving_frames(robot))[-1]
    return -fixed.mass * float(np.dot(robot.gravity, fixed.com))


def _mass_fields(robot: Robot, frames: list[MovingFrame], places: dict[str, Place]) -> Fields:
    *bodies, _ = composite_inertias(robot, frames, places)
    return {
        "mass": [body.mass for body in bodies],
        "mass_centre": [body.com for body in bodies],
        "inertia": [body.entries for body in bodies],
        "friction": [coordinate.friction for coordinate in robot.coordinates],
        "lower": [coordinate.lower for coordinate in robot.coordinates],
        "upper": [coordinate.upper for coordinate in robot.coordinates],
        "gravity": robot.gravity,
    }


def _tree_fields(frames: list[MovingFrame]) -> Fields:
    return {
        "parent": [frame.parent for frame in frames],
        "motion": [_MOTION[frame.motion.kind] for frame in frames],
        "coordinate": [frame.coordinate for frame in frames],
        "offset_rotation": [frame.T_parent_frame[:3, :3] for frame in frames],
        "offset_position": [frame.T_parent_frame[:3, 3] for frame in frames],
        "axis": [_unit(frame.motion.axis) for frame in frames],
    }


def _law_fields(robot: Robot) -> dict[str, ArrayLike]:
    kinds = list(MUSCLE_LAWS)
    in_core = ["ideal" if m.model.custom else law_of(m.model).kind for m in robot.muscles]
    values = [muscle_laws.muscle_parameters(muscle) for muscle in robot.muscles]
    return {
        "law_kind": [kinds.index(kind) for kind in in_core],
        "law_parameter": [number for numbers in values for number in numbers.values()],
    }


def compile_blob(robot: Robot, *, single: bool = False) -> bytes:
    """Compile a robot, with its active cable set and operational space.

    Args:
        robot: A valid robot.
        single: Use single precision, for a core compiled with `CARDSFLOW_FLOAT`, for example for a
            microcontroller.

    Raises:
        CardsflowError: A number is too large for single precision, or a muscle path uses a feature
            that the C core does not support.
    """
    require_supported_features(robot)
    frames, places = moving_frames(robot)
    tasks = robot.task_frames
    variables = robot_variables(robot)
    counts = (
        path_counts(robot)
        | variable_counts(variables)
        | {
            "dofs": len(robot.coordinates),
            "frames": len(frames),
            "muscles": len(robot.muscles),
            "tasks": len(tasks),
            "closures": len(closures(robot)),
            "law_parameters": sum(len(law_of(muscle.model).parameters) for muscle in robot.muscles),
            "robots": 1,
        }
    )
    return pack_blob(
        counts,
        _tree_fields(frames)
        | _law_fields(robot)
        | path_fields(robot, places)
        | loop_fields(robot, places)
        | variable_fields(variables)
        | _mass_fields(robot, frames, places)
        | {
            "task_kind": [int(task.is_orientation) for task in tasks],
            "task_frame": [places[task.link].frame for task in tasks],
            "task_rotation": [places[task.link].T_frame_link[:3, :3] for task in tasks],
            "task_position": [places[task.link].point(task.position) for task in tasks],
        },
        single=single,
    )
