"""Poses of all links at many joint positions."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from addin_sdfusion.robot import Motion, Robot
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.core.frames import moving_frames, transform
from sim_dart.core.variables import robot_variables, variable_values

Poses = Mapping[str, FloatArray]
"""T_world_link by link name, including `world`, at K frames, shape (K, 4, 4)."""


def link_poses(robot: Robot, q: FloatArray) -> Poses:
    """Return the poses of all links.

    Args:
        q: Joint positions at K frames, shape (K, n), in [rad] or [m].
    """
    frames, frame_of = moving_frames(robot)
    x = variable_values(robot_variables(robot), q)
    world = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    T_world_frame: list[FloatArray] = []
    for frame in frames:
        parent = world if frame.parent < 0 else T_world_frame[frame.parent]
        moved = motion_transforms(frame.motion, x[:, frame.coordinate])
        T_world_frame.append(parent @ frame.T_parent_frame @ moved)
    return {
        link: (world if pose.frame < 0 else T_world_frame[pose.frame]) @ pose.T_frame_link
        for link, pose in frame_of.items()
    }


def coordinate_axes(
    robot: Robot, q: FloatArray, poses: Poses
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return points on the axes of the coordinates and their directions, shape (K, 3) each.

    Args:
        q: Joint positions at K frames, shape (K, n), in [rad] or [m].
    """
    axes: dict[str, tuple[FloatArray, FloatArray]] = {}
    variables = robot_variables(robot)
    x, zeros = variable_values(variables, q), np.zeros(len(q))
    for joint in robot.joints:
        T = poses[joint.parent] @ transform(joint.T_parent_joint)
        drivers = zip(variables.driver[joint.name], variables.constant[joint.name], strict=True)
        for motion, (driver, still) in zip(joint.motions, drivers, strict=True):
            T = T @ motion_transforms(motion, x[:, driver] if driver is not None else zeros + still)
            if driver is not None:
                name = joint.coordinates[motion.coordinate].name
                axes.setdefault(name, (T[:, :3, 3], T[:, :3, :3] @ np.array(motion.axis)))
    return axes


def motion_transforms(motion: Motion, values: FloatArray) -> FloatArray:
    """Return the transforms of a motion at values of its coordinate, shape (K, 4, 4).

    Args:
        values: Values of the coordinate, shape (K,), in [rad] or [m].
    """
    axis = np.array(motion.axis) / np.linalg.norm(motion.axis)
    T = np.tile(np.eye(4), (len(values), 1, 1))
    if motion.kind == "translation":
        T[:, :3, 3] = values[:, np.newaxis] * axis
        return T
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sin, cos = np.sin(values)[:, np.newaxis, np.newaxis], np.cos(values)[:, np.newaxis, np.newaxis]
    T[:, :3, :3] = np.eye(3) + sin * K + (1.0 - cos) * (K @ K)  # Rodrigues
    return T


def moved_point(T: FloatArray, point: tuple[float, float, float]) -> FloatArray:
    """Return the world positions of a point at poses T of its frame, shape (K, 3)."""
    moved: FloatArray = T[:, :3, :3] @ np.array(point) + T[:, :3, 3]
    return moved
