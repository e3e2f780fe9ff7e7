"""CoreDynamics: the terms of M qdd + C + G = -L^T f + A tau, all from the C core."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray
from sim_dart.core.mass_check import require_inertia
from sim_dart.core.tasks import task_rows
from sim_dart.muscles.paths import finite, vector

from .base import RobotTerms


class CoreDynamics(RobotTerms):
    """Dynamics of a robot from the C core alone; equal to `DartDynamics`, and faster.

    M by composite bodies, C and G by Newton and Euler's equations, in world axes about the origin
    of each frame. Joint damping is not part of these terms; `damping` gives it apart. Every array
    returned is the caller's own.

    Args:
        robot: The robot; its active cable set and operational space count.

    Raises:
        RobotError: The robot is not valid.
        InputError: Its mass matrix is singular.
    """

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot)
        core = self._paths.core
        n, k = self.n, len(robot.task_frames)
        self._core, self._handle = core, core.handle
        self._mass_matrix = core.array("mass_matrix", n, n)
        self._coriolis, self._gravity = core.array("coriolis", n), core.array("gravity", n)
        self._qdd, self._task_bias = core.array("qdd", n), core.array("task_bias", 3 * k)
        self._task_rows = task_rows(robot)
        self._stiffness = np.array([c.stiffness for c in robot.coordinates])
        self._rest = np.array([c.rest for c in robot.coordinates])
        require_inertia(robot, self.mass_matrix([c.initial for c in robot.coordinates]))

    def mass_matrix(self, q: ArrayLike) -> FloatArray:
        """M(q), shape (n, n), in [kg·m²] for revolute and [kg] for prismatic coordinates.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        self._move(q)
        self._core.update_mass_matrix(self._handle)
        return self._mass_matrix.copy()

    def coriolis(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """C(q, qd), the velocity terms as a vector, shape (n,), in [N·m] or [N].

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        """
        self._move(q)
        self._core.update_coriolis(self._handle, self._rates(qd))
        return self._coriolis.copy()

    def gravity(self, q: ArrayLike) -> FloatArray:
        """G(q) = dV/dq, of the weight and of the joints' springs, shape (n,), in [N·m] or [N].

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
        """
        self._move(q)
        self._core.update_gravity(self._handle)
        return self._gravity.copy()

    def task_bias(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """J'(q, qd) qd, shape (k,), in [m/s²] or [rad/s²].

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        """
        self._move(q)
        self._core.update_task_bias(self._handle, self._rates(qd))
        return self._task_bias[self._task_rows]

    def acceleration(self, q: ArrayLike, qd: ArrayLike, torques: ArrayLike) -> FloatArray:
        """Solve M qdd + C + G = tau for qdd, shape (n,), by articulated bodies.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            torques: tau, all generalised forces, shape (n,), in [N·m] or [N].
        """
        self._move(q)
        tau = finite("torques", vector("torques", torques, self.n))
        springs = self._stiffness * (vector("q", q, self.n) - self._rest)
        none = bytes(8 * self.n)
        self._core.accelerate(self._handle, self._rates(qd), (tau - springs).tobytes(), none)
        return self._qdd.copy()

    def _move(self, q: ArrayLike) -> None:
        self._core.move(self._handle, finite("q", vector("q", q, self.n)).tobytes())

    def _rates(self, qd: ArrayLike) -> bytes:
        return finite("qd", vector("qd", qd, self.n)).tobytes()
