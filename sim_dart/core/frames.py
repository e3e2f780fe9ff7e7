"""Moving frames of a robot: the nodes of its kinematic tree after fixed joints are merged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from addin_sdfusion.robot import WORLD, Inertia, Motion, Pose, Robot
from addin_sdfusion.robot.model.rotations import axis_rotation, normalized, rotation
from addin_sdfusion.robot.model.transform import Transform

from .arrays import FloatArray
from .variables import robot_variables


def transform(pose: Pose) -> FloatArray:
    """Return the homogeneous matrix of a pose, shape (4, 4)."""
    T = np.eye(4)
    T[:3, :3] = rotation(pose.rpy)
    T[:3, 3] = pose.position
    return T


def inverse(T: FloatArray) -> FloatArray:
    """Return the inverse of a homogeneous matrix, shape (4, 4)."""
    inverted = np.eye(4)
    inverted[:3, :3] = T[:3, :3].T
    inverted[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return inverted


@dataclass(frozen=True)
class Place:
    """Pose of a link in the moving frame to which it is fixed.

    Attributes:
        frame: Index of the moving frame to which the link is fixed, -1 for the world.
        T_frame_link: Pose of the link in that frame, shape (4, 4).
    """

    frame: int
    T_frame_link: FloatArray

    def point(self, position: tuple[float, float, float]) -> FloatArray:
        """Return a point given in the link frame in the moving frame, shape (3,), in [m]."""
        moved: FloatArray = (
            self.T_frame_link[:3, :3] @ np.array(position) + self.T_frame_link[:3, 3]
        )
        return moved

    def inertia(self, inertia: Inertia) -> Inertia:
        """Return an inertia given in the link frame in the moving frame."""
        R, p = self.T_frame_link[:3, :3].tolist(), self.T_frame_link[:3, 3].tolist()
        return inertia.moved(Transform(R, p))


@dataclass(frozen=True)
class MovingFrame:
    """Frame that is moved by one motion of a joint. The axis of motion contains its origin.

    Attributes:
        motion: The rotation or translation.
        coordinate: Index of the variable that drives the motion; see `variables`.
        parent: Index of the parent frame, -1 for the world.
        T_parent_frame: Pose of the frame in the parent frame at q = 0, shape (4, 4).
    """

    motion: Motion
    coordinate: int
    parent: int
    T_parent_frame: FloatArray


def _displaced(motion: Motion, displacement: float) -> FloatArray:
    """Return the transform of a motion at a constant displacement, in [rad] or [m]."""
    T = np.eye(4)
    axis = normalized(motion.axis)
    if motion.kind == "rotation":
        T[:3, :3] = axis_rotation(axis, displacement)
    else:
        T[:3, 3] = displacement * np.array(axis)
    return T


def moving_frames(robot: Robot) -> tuple[list[MovingFrame], dict[str, Place]]:
    """Return the moving frames, parents first, and the place of every link by name."""
    frames: list[MovingFrame] = []
    places = {WORLD: Place(-1, np.eye(4))}
    variables = robot_variables(robot)
    for joint in robot.joints:
        parent = places[joint.parent]
        frame, T_frame_next = parent.frame, parent.T_frame_link @ transform(joint.T_parent_joint)
        drivers, constants = variables.driver[joint.name], variables.constant[joint.name]
        for motion, driver, displacement in zip(joint.motions, drivers, constants, strict=True):
            if driver is None:
                T_frame_next = T_frame_next @ _displaced(motion, displacement)
                continue
            frames.append(MovingFrame(motion, driver, frame, T_frame_next))
            frame, T_frame_next = len(frames) - 1, np.eye(4)
        places[joint.child] = Place(frame, T_frame_next @ inverse(transform(joint.T_child_joint)))
    return frames, places
