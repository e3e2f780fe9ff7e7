"""Poses of a robot's links in the world."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from .coupling import all_values
from .joint import Joint, Motion
from .pose import IDENTITY, Pose
from .robot import WORLD, Robot
from .rotations import compose, inverse, normalized
from .transform import motion_transform


def initial_poses(robot: Robot) -> dict[str, Pose]:
    """Return the pose of every link in the world, at the initial values of the coordinates."""
    return link_poses(robot, {c.name: c.initial for c in robot.coordinates})


def link_poses(robot: Robot, q: Mapping[str, float]) -> dict[str, Pose]:
    """Return the pose of every link in the world.

    Args:
        robot: A valid robot.
        q: Values of the free coordinates by name, in [rad] or [m].
    """
    values = all_values(robot, q)

    def displacement(joint: Joint, motion: Motion) -> float:
        x = 0.0 if motion.is_fixed else values[joint.coordinates[motion.coordinate].name]
        return motion.displacement(x)

    return _poses(robot, displacement)


def unmoved_poses(robot: Robot) -> dict[str, Pose]:
    """Return the pose of every link in the world without motions, except constant ones."""
    return _poses(robot, lambda _, motion: motion.displacement(0.0) if motion.is_fixed else 0.0)


def _poses(robot: Robot, displacement: Callable[[Joint, Motion], float]) -> dict[str, Pose]:
    poses = {WORLD: IDENTITY}
    for joint in robot.joints:
        T = compose(poses[joint.parent], joint.T_parent_joint)
        for motion in joint.motions:
            axis = normalized(motion.axis)
            T = compose(T, motion_transform(motion.kind, axis, displacement(joint, motion)).pose())
        poses[joint.child] = compose(T, inverse(joint.T_child_joint))
    return poses
