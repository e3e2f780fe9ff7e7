"""Task coordinates y: their rows in the values of the task frames, and the bias of angles."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.robot import ANGLES, POSITIONS

from .arrays import FloatArray

_ROWS = {axis: k for axes in (POSITIONS, ANGLES) for k, axis in enumerate(axes)}


def task_rows(robot: Robot) -> list[int]:
    """Return the row of every task coordinate in an array with three rows per task frame."""
    return [3 * k + _ROWS[axis] for k, frame in enumerate(robot.task_frames) for axis in frame.axes]


def point_rows(robot: Robot) -> list[int]:
    """Return the rows of the position task frames in an array with three rows per task frame."""
    frames = enumerate(robot.task_frames)
    return [3 * k + row for k, frame in frames if not frame.is_orientation for row in range(3)]


def angle_bias(angles: FloatArray, w: FloatArray, w_bias: FloatArray) -> FloatArray:
    """Return the part of (alpha'', beta'', gamma'') that is independent of qdd, in [rad/s²].

    With E(alpha, beta) y' = w for the angles y, the bias is E^-1 (w_bias - E' y').

    Args:
        angles: alpha, beta, gamma of R = Rx(alpha) Ry(beta) Rz(gamma), shape (3,), in [rad].
        w: Angular velocity in the world, shape (3,), in [rad/s].
        w_bias: Angular acceleration at qdd = 0, shape (3,), in [rad/s²].
    """
    ca, sa = np.cos(angles[0]), np.sin(angles[0])
    cb, sb = np.cos(angles[1]), np.sin(angles[1])
    E = np.array([[1.0, 0.0, sb], [0.0, ca, -sa * cb], [0.0, sa, ca * cb]])
    rates = np.linalg.solve(E, w)
    dE_alpha = np.array([[0.0, 0.0, 0.0], [0.0, -sa, -ca * cb], [0.0, ca, -sa * cb]])
    dE_beta = np.array([[0.0, 0.0, cb], [0.0, 0.0, sa * sb], [0.0, 0.0, -ca * sb]])
    E_rate = rates[0] * dE_alpha + rates[1] * dE_beta
    bias: FloatArray = np.linalg.solve(E, w_bias - E_rate @ rates)
    return bias
