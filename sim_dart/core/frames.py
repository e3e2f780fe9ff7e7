"""The moving frames of a robot: what is left of its tree when fixed joints are merged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from addin_sdfusion.robot import WORLD, InputError, Motion, Pose, Robot
from addin_sdfusion.robot.model.rotations import rotation

from .arrays import FloatArray


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
    """A frame that one motion of a joint moves; the motion's axis passes through its origin.

    Attributes:
        motion: The motion.
        coordinate: Index in q of the coordinate that drives it.
        parent: Index of the moving frame that it is fixed to at q = 0, -1 for the world.
        T_parent_frame: Pose of the frame in the parent frame at q = 0, shape (4, 4).
    """

    motion: Motion
    coordinate: int
    parent: int
    T_parent_frame: FloatArray


def refuse_driven(robot: Robot, what: str) -> None:
    """Refuse functions, couplings and locks between coordinates and motions.

    Args:
        robot: A valid robot.
        what: What cannot be done with them, as a participle.

    Raises:
        InputError: There is one; the message names the joint.
    """
    for joint in robot.driven_joints:
        problem = "functions of coordinates, couplings and locks are read and kept, but not yet "
        raise InputError(f"joint {joint.name!r}: {problem}{what}")
    for c in robot.coordinates:
        if c.armature or c.limit_force:
            problem = "armatures and limit forces are read and kept, but not yet "
            raise InputError(f"coordinate {c.name!r}: {problem}{what}")


def moving_frames(robot: Robot) -> tuple[list[MovingFrame], dict[str, Place]]:
    """The frames that move, parents first, and where every link is fixed."""
    frames: list[MovingFrame] = []
    places = {WORLD: Place(-1, np.eye(4))}
    first = 0
    refuse_driven(robot, "simulated")
    for joint in robot.joints:
        parent = places[joint.parent]
        frame, T_frame_next = parent.frame, parent.T_frame_link @ transform(joint.T_parent_joint)
        for motion in joint.motions:
            frames.append(MovingFrame(motion, first + motion.coordinate, frame, T_frame_next))
            frame, T_frame_next = len(frames) - 1, np.eye(4)
        first += len(joint.coordinates)
        places[joint.child] = Place(frame, T_frame_next @ inverse(transform(joint.T_child_joint)))
    return frames, places
