"""Bias of the task from the Jacobians of DART."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from addin_sdfusion.robot import Robot, TaskFrame
from sim_dart.core.tasks import task_rows
from sim_dart.dart.skeleton import Skeleton


def task_bias(
    robot: Robot, skeleton: Skeleton, q: NDArray[np.float64], qd: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return J'(q, qd) qd of the task, shape (k,), in [m/s²] or [rad/s²]."""
    skeleton.set_positions(q)
    skeleton.set_velocities(qd)
    values = [_frame_bias(skeleton, frame) for frame in robot.task_frames]
    return np.array(values).reshape(-1)[task_rows(robot)]


def _frame_bias(skeleton: Skeleton, frame: TaskFrame) -> NDArray[np.float64]:
    dart, body = skeleton.dart, skeleton.bodies[frame.link]
    velocities = dart.getVelocities()
    if not frame.is_orientation:
        J_rate = dart.getLinearJacobianDeriv(body, np.array(frame.position))
        return np.asarray(J_rate @ velocities, dtype=np.float64)
    angles = Rotation.from_matrix(body.getWorldTransform().rotation()).as_euler("XYZ")
    w = dart.getAngularJacobian(body) @ velocities
    return _angle_bias(angles, w, dart.getAngularJacobianDeriv(body) @ velocities)


def _angle_bias(
    angles: NDArray[np.float64], w: NDArray[np.float64], w_bias: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return E^-1 (w_bias - E' y') for the angles y with E(alpha, beta) y' = w."""
    ca, sa = np.cos(angles[0]), np.sin(angles[0])
    cb, sb = np.cos(angles[1]), np.sin(angles[1])
    E = np.array([[1.0, 0.0, sb], [0.0, ca, -sa * cb], [0.0, sa, ca * cb]])
    rates = np.linalg.solve(E, w)
    dE_alpha = np.array([[0.0, 0.0, 0.0], [0.0, -sa, -ca * cb], [0.0, ca, -sa * cb]])
    dE_beta = np.array([[0.0, 0.0, cb], [0.0, 0.0, sa * sb], [0.0, 0.0, -ca * sb]])
    E_rate = rates[0] * dE_alpha + rates[1] * dE_beta
    return np.linalg.solve(E, w_bias - E_rate @ rates)
