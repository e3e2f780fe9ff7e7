"""Positions, accelerations and Jacobians of links along a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.robot import TaskFrame, TaskSet
from sim_dart.core.arrays import FloatArray

from .core import CoreDynamics

_CORNERS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_ARMS, _SIDES = [1, 2, 3], [1, 2, 0]
"""Points on the axes of a link, and the axes of the forces there that form couples."""


@dataclass(frozen=True, eq=False)
class LinkMotion:
    """Motion of k links at T poses: four points of each link, its origin and one on each axis.

    Attributes:
        points: Positions in the world, shape (T, k, 4, 3), in [m].
        accelerations: Their accelerations, shape (T, k, 4, 3), in [m/s²].
        jacobians: Their Jacobians, shape (T, k, 4, 3, n).
    """

    points: FloatArray
    accelerations: FloatArray
    jacobians: FloatArray

    @property
    def origins(self) -> FloatArray:
        """Origins of the links in the world, shape (T, k, 3), in [m]."""
        return self.points[:, :, 0]

    @property
    def rotations(self) -> FloatArray:
        """Rotation matrices R_world_link, shape (T, k, 3, 3)."""
        return np.moveaxis(self.points[:, :, 1:] - self.points[:, :, :1], -2, -1)

    def generalised_forces(self, forces: FloatArray, moments: FloatArray) -> FloatArray:
        """Return the generalised forces of wrenches on the links, shape (T, n).

        Args:
            forces: Forces at the origins of the links, world axes, shape (T, k, 3), in [N].
            moments: Moments, world axes, shape (T, k, 3), in [N·m].
        """
        R = self.rotations
        in_link_axes = np.einsum("tkij,tki->tkj", R, moments)  # in the axes of the link
        pulls = np.zeros_like(self.points)
        for arm, side, axis in zip(_ARMS, _SIDES, (2, 0, 1), strict=True):
            pulls[:, :, arm] = in_link_axes[:, :, axis, None] * R[:, :, :, side]
        pulls[:, :, 0] = forces - pulls[:, :, 1:].sum(axis=2)
        generalised: FloatArray = np.einsum("tkpin,tkpi->tn", self.jacobians, pulls)
        return generalised


def link_motion(
    robot: Robot, links: Sequence[str], q: FloatArray, qd: FloatArray, qdd: FloatArray
) -> LinkMotion:
    """Return the motion of links.

    Args:
        q: Positions of the coordinates, shape (T, n).
        qd: Velocities, shape (T, n).
        qdd: Accelerations, shape (T, n).

    Raises:
        UnknownNameError: A link does not exist.
    """
    measured = LinkPoints(robot, links)
    points, jacobians = measured.at(q)
    accelerations = np.empty_like(points)
    for k in range(len(q)):
        bias = measured.dynamics.task_bias(q[k], qd[k]).reshape(points.shape[1:])
        accelerations[k] = jacobians[k] @ qdd[k] + bias
    return LinkMotion(points, accelerations, jacobians)


class LinkPoints:
    """Four points of each of k links: its origin and one on each axis.

    Attributes:
        dynamics: Dynamics whose task coordinates are the points.
    """

    def __init__(self, robot: Robot, links: Sequence[str]) -> None:
        frames = [
            TaskFrame(f"{robot.link(name).name} {k}", name, corner)
            for name in links
            for k, corner in enumerate(_CORNERS)
        ]
        measured = replace(robot, task_sets=(TaskSet("links", tuple(frames)),), task_set="links")
        self.dynamics = CoreDynamics(measured, may_be_singular=True)
        self._shape = (len(links), 4, 3)

    def at(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return positions, shape (T, k, 4, 3), in [m], and Jacobians, shape (T, k, 4, 3, n).

        Args:
            q: Positions of the coordinates, shape (T, n).
        """
        dynamics, count = self.dynamics, len(q)
        points = np.empty((count, *self._shape))
        jacobians = np.empty((count, *self._shape, dynamics.n))
        for k, pose in enumerate(q):
            jacobians[k] = dynamics.task_jacobian(pose).reshape(jacobians.shape[1:])
            points[k] = dynamics.task_position(pose).reshape(self._shape)
        return points, jacobians
