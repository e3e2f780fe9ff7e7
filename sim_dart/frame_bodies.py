"""What the moving frames of a robot carry, as bodies in the world: centre of mass and momentum."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Robot

from .blob import carried_masses
from .core import Core
from .frames import FloatArray, moving_frames
from .mechanism import Momentum


class FrameBodies:
    """The bodies of a robot, where the core moved them last.

    Args:
        robot: A valid robot.
        core: Its core.
    """

    def __init__(self, robot: Robot, core: Core) -> None:
        frames, places = moving_frames(robot)
        count = len(frames)
        *bodies, fixed = carried_masses(robot, frames, places)
        self._frames = frames
        self._masses = np.array([body.mass for body in bodies])
        self._centres = np.array([body.centre for body in bodies]).reshape(-1, 3)
        self._inertias = [body.inertia for body in bodies]
        self._fixed = fixed.mass * fixed.centre
        self._rotations = core.array("frame_rotation", count, 3, 3)
        self._origins = core.array("frame_origin", count, 3)
        self._axes = core.array("frame_axis", count, 3)

    def first_moment(self) -> FloatArray:
        """Sum of mass times position, of what does not move as well, shape (3,), in [kg·m]."""
        moving: FloatArray = self._masses @ self._places()
        return moving + self._fixed

    def momentum(self, qd: FloatArray) -> Momentum:
        """Linear and angular momentum.

        Args:
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        """
        spins, velocities = self._motion(qd)
        arms = self._places() - self._origins
        p = self._masses[:, None] * (velocities + np.cross(spins, arms))
        own = [
            R @ _matrix(inertia) @ R.T @ w
            for R, inertia, w in zip(self._rotations, self._inertias, spins, strict=True)
        ]
        turning = np.array(own).reshape(-1, 3) + np.cross(self._places(), p)
        return Momentum(p.sum(axis=0), turning.sum(axis=0))

    def _places(self) -> FloatArray:
        """Centres of mass in the world, shape (frames, 3)."""
        turned: FloatArray = np.einsum("kij,kj->ki", self._rotations, self._centres)
        return self._origins + turned

    def _motion(self, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angular velocity of every frame, and velocity of its origin."""
        spins, velocities = np.zeros_like(self._axes), np.zeros_like(self._axes)
        for k, frame in enumerate(self._frames):
            own = qd[frame.coordinate] * self._axes[k]
            if frame.parent >= 0:
                spins[k] = spins[frame.parent]
                arm = self._origins[k] - self._origins[frame.parent]
                velocities[k] = velocities[frame.parent] + np.cross(spins[k], arm)
            moved = spins if frame.motion.kind == "rotation" else velocities
            moved[k] += own
        return spins, velocities


def _matrix(inertia: FloatArray) -> FloatArray:
    """Of xx, yy, zz, xy, xz, yz, shape (3, 3)."""
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
