"""Loop joints by link poses only; accelerations by the null space of the constraints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from addin_sdfusion.robot import WORLD, LoopJoint, Pose, Robot
from sim_dart import DartDynamics

Array = NDArray[np.float64]
STEP = 1e-30


def pose_matrix(pose: Pose) -> Array:
    """Return the homogeneous matrix of a pose, shape (4, 4)."""
    T = np.eye(4)
    (cr, cp, cy), (sr, sp, sy) = np.cos(pose.rpy), np.sin(pose.rpy)
    Rz, Ry = (
        np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]),
        np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]),
    )
    T[:3, :3] = Rz @ Ry @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    T[:3, 3] = pose.position
    return T


def skew(a: Array) -> Array:
    """Return the cross product matrix of a vector."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def rotation(axis: Array, angle: complex) -> Array:
    """Return a rotation matrix by Rodrigues' formula, also for complex angles."""
    K = skew(axis)
    R: Array = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    return R


def link_poses(robot: Robot, q: NDArray[np.complex128]) -> dict[str, NDArray[np.complex128]]:
    """Return T_world_link at complex coordinates."""
    values = dict(zip((c.name for c in robot.coordinates), q, strict=True))
    poses = {WORLD: np.eye(4, dtype=complex)}
    for joint in robot.joints:
        T = poses[joint.parent] @ pose_matrix(joint.T_parent_joint)
        for motion in joint.motions:
            M, way = np.eye(4, dtype=complex), values[joint.coordinates[motion.coordinate].name]
            if motion.kind == "rotation":
                M[:3, :3] = rotation(np.array(motion.axis), way)
            else:
                M[:3, 3] = way * np.array(motion.axis)
            T = T @ M
        poses[joint.child] = T @ np.linalg.inv(pose_matrix(joint.T_child_joint))
    return poses


def residual(loop: LoopJoint, T: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the constraint residual, with redundant rows; it is zero if the loop is closed.

    Args:
        loop: The joint.
        T: Pose of the joint frame on the child in the joint frame on the parent.
    """
    R, p = T[:3, :3], T[:3, 3]
    whole = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    a = np.array(loop.axes[0] if loop.axes else (0.0, 0.0, 0.0))
    straight, along = skew(a) @ R @ a, skew(a) @ p
    rows = {
        "fixed": (p, whole),
        "ball": (p,),
        "revolute": (p, straight),
        "prismatic": (along, whole),
        "cylindrical": (along, straight),
        "planar": ([a @ p], straight),
        "universal": (p, [a @ R @ np.array(loop.axes[-1] if loop.axes else a)]),
    }
    return np.concatenate(rows[loop.type])


def residuals(robot: Robot, q: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the residuals of all loop joints."""
    poses = link_poses(robot, q)
    found = []
    for loop in robot.loops:
        A = poses[loop.parent] @ pose_matrix(loop.T_parent_joint)
        B = poses[loop.child] @ pose_matrix(loop.T_child_joint)
        found.append(residual(loop, np.linalg.inv(A) @ B))
    return np.concatenate(found)


def loop_jacobian(robot: Robot, q: Array) -> Array:
    """Return the Jacobian of the residuals by complex steps, shape (rows, n)."""
    columns = [residuals(robot, q + 1j * STEP * e).imag / STEP for e in np.eye(len(q))]
    return np.array(columns).T


def loop_acceleration(robot: Robot, q: Array, qd: Array, tau: Array) -> Array:
    """Return qdd = N z + qdd_0, where N is the null space of J and qdd_0 keeps the loops closed."""
    dynamics, J = DartDynamics(robot), loop_jacobian(robot, q)
    e = 1e-5

    def rate(s: float) -> Array:
        return np.asarray(residuals(robot, q + (s + 1j * STEP) * qd).imag / STEP)

    bias = (8 * (rate(e) - rate(-e)) - rate(2 * e) + rate(-2 * e)) / (12 * e)
    N = null_space(J, rcond=1e-8)
    kept = np.linalg.lstsq(J, -bias, rcond=1e-8)[0]
    M = dynamics.mass_matrix(q)
    load = tau - dynamics.coriolis(q, qd) - dynamics.gravity(q)
    z = np.linalg.solve(N.T @ M @ N, N.T @ (load - M @ kept))
    return np.asarray(kept + N @ z)
