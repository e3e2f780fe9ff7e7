"""The moving frames of a robot: what is left of its tree when fixed joints are merged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import WORLD, Joint, Pose, Robot
from addin_sdfusion.robot.pose import rotation

FloatArray = NDArray[np.float64]


def transform(pose: Pose) -> FloatArray:
    """The homogeneous matrix of a pose, shape (4, 4)."""
    T = np.eye(4)
    T[:3, :3] = rotation(pose.rpy)
    T[:3, 3] = pose.position
    return T


def inverse(T: FloatArray) -> FloatArray:
    """The inverse of a homogeneous matrix, shape (4, 4)."""
    inverted = np.eye(4)
    inverted[:3, :3] = T[:3, :3].T
    inverted[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return inverted


@dataclass(frozen=True)
class Place:
    """Where a link is fixed.

    Attributes:
        frame: Index of the moving frame that carries the link, -1 for the world.
        T_frame_link: Pose of the link in that frame, shape (4, 4).
    """

    frame: int
    T_frame_link: FloatArray

    def point(self, position: tuple[float, float, float]) -> FloatArray:
        """A point of the link, shape (3,), in the moving frame."""
        moved: FloatArray = (
            self.T_frame_link[:3, :3] @ np.array(position) + self.T_frame_link[:3, 3]
        )
        return moved


@dataclass(frozen=True)
class MovingFrame:
    """A frame that one joint moves; its axis passes through its origin.

    Attributes:
        joint: The joint.
        parent: Index of the moving frame that the joint is fixed to, -1 for the world.
        T_parent_joint: Pose of the frame in the parent frame at q = 0, shape (4, 4).
    """

    joint: Joint
    parent: int
    T_parent_joint: FloatArray


def moving_frames(robot: Robot) -> tuple[list[MovingFrame], dict[str, Place]]:
    """The frames that move, in the order of the coordinates, and where every link is fixed.

    Args:
        robot: A valid robot.
    """
    frames: list[MovingFrame] = []
    places = {WORLD: Place(-1, np.eye(4))}
    for joint in robot.joints:
        parent = places[joint.parent]
        T_frame_joint = parent.T_frame_link @ transform(joint.T_parent_joint)
        T_joint_child = inverse(transform(joint.T_child_joint))
        if joint.type == "fixed":
            places[joint.child] = Place(parent.frame, T_frame_joint @ T_joint_child)
        else:
            places[joint.child] = Place(len(frames), T_joint_child)
            frames.append(MovingFrame(joint, parent.frame, T_frame_joint))
    return frames, places
