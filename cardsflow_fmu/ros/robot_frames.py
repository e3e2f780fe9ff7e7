"""URDF frames of a robot, as transforms from parent to child along a motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from addin_sdfusion.robot import WORLD, Robot
from addin_sdfusion.robot.model.pose import IDENTITY
from addin_sdfusion.robot.transforms.joint_chains import single_joints
from cardsflow_fmu.results.viewer.scene.link_poses import link_poses, motion_transforms
from cardsflow_fmu.ros_interface.node import Values, header
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.core.frames import transform


def urdf_frames(robot: Robot) -> Mapping[str, FloatArray]:
    """Return T_link_frame of each link: the pose of its URDF frame, which is the joint frame.

    For a robot that URDF cannot represent, the frames are the link frames.
    """
    if robot.driven_joints:
        return {link.name: np.eye(4) for link in robot.links}
    joints = single_joints(robot)
    return {joint.child: transform(joint.T_child_joint) for joint in joints}


def frame_transforms(robot: Robot, q: FloatArray) -> Iterator[tuple[str, str, FloatArray]]:
    """Yield parent, child and T_parent_child, shape (K, 4, 4), of each URDF frame.

    Args:
        q: Joint positions at K times, shape (K, n), in [rad] or [m].
    """
    if robot.driven_joints:
        poses = link_poses(robot, q)
        yield from ((WORLD, link.name, poses[link.name]) for link in robot.links)
        return
    columns = {c.name: k for k, c in enumerate(robot.coordinates)}
    frames = urdf_frames(robot)
    for joint in single_joints(robot):
        T_parent = frames.get(joint.parent, transform(IDENTITY))
        T = np.linalg.inv(T_parent) @ transform(joint.T_parent_joint)
        moved = np.broadcast_to(T, (len(q), 4, 4))
        if joint.motion is not None and joint.coordinate is not None:
            moved = T @ motion_transforms(joint.motion, q[:, columns[joint.coordinate.name]])
        yield joint.parent, joint.child, moved


def point_values(position: FloatArray) -> Values:
    """Return positions, shape (K, 3), as fields of a `Point` or a `Vector3`."""
    return dict(zip("xyz", position.T, strict=True))


def quaternion_values(R: FloatArray) -> Values:
    """Return rotation matrices, shape (K, 3, 3), as fields of a `Quaternion`.

    Quaternions of matrices that are not finite are NaN.
    """
    quaternions, is_finite = np.full((len(R), 4), np.nan), np.isfinite(R).all(axis=(1, 2))
    if is_finite.any():
        quaternions[is_finite] = Rotation.from_matrix(R[is_finite]).as_quat()
    return dict(zip("xyzw", quaternions.T, strict=True))


def pose_values(T: FloatArray) -> Values:
    """Return poses, shape (K, 4, 4), as fields of a `Pose`."""
    return {"position": point_values(T[:, :3, 3]), "orientation": quaternion_values(T[:, :3, :3])}


def transform_values(time_ns: NDArray[np.int64], parent: str, child: str, T: FloatArray) -> Values:
    """Return T_parent_child at K times, shape (K, 4, 4), as fields of a `TransformStamped`."""
    moved = {"translation": point_values(T[:, :3, 3]), "rotation": quaternion_values(T[:, :3, :3])}
    return {"header": header(time_ns, parent), "child_frame_id": child, "transform": moved}
