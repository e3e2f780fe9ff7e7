"""Robot dynamics computed by the C core."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.muscle_laws import law_of
from sim_dart.core.arrays import BoolArray, FloatArray, finite
from sim_dart.core.mass_check import require_inertia

from .base import RobotDynamics


class CoreDynamics(RobotDynamics):
    """Dynamics of a robot, computed by the C core. Results equal `DartDynamics`, but are faster.

    The composite rigid body algorithm computes M, and the Newton-Euler equations compute C and G,
    in world axes about the origin of each frame. For errors and attributes see `RobotDynamics`.

    Args:
        robot: The robot. Its active cable set and operational space are used.
        may_be_singular: Accept a robot whose mass matrix is singular.
    """

    def __init__(self, robot: Robot, *, may_be_singular: bool = False) -> None:
        super().__init__(robot)
        core = self._paths.core
        n = self.n
        self._core, self._handle = core, core.handle
        self._M, self._C, self._G = (
            core.array("mass_matrix", n, n),
            core.array("coriolis", n),
            core.array("gravity", n),
        )
        self._qdd = core.array("qdd", n)
        forces = any(c.limit_force for c in robot.coordinates)
        forces |= any(law_of(muscle.model).sags for muscle in robot.muscles)
        # whether G has terms other than weight and springs of q
        self._has_more = forces or bool(robot.driven_joints)
        self._armature = np.array([c.armature for c in robot.coordinates]).tobytes()
        if not may_be_singular:
            require_inertia(robot, self.mass_matrix([c.initial for c in robot.coordinates]))

    def acceleration(self, q: ArrayLike, qd: ArrayLike, torques: ArrayLike) -> FloatArray:
        """Solve M qdd + C + G = tau for qdd, shape (n,), in [rad/s²] or [m/s²].

        With loops, solve M qdd + C + G = tau + J'p with constraint forces p so that the loops stay
        closed, J qdd = -J' qd. The articulated body algorithm is used if possible.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            torques: Sum of all generalised forces tau, shape (n,), in [N·m] or [N].
        """
        at, rates = finite("q", q, self.n), finite("qd", qd, self.n)
        tau = finite("torques", torques, self.n)
        if self._has_more:
            self._core.move(self._handle, at.tobytes())
            self._core.update_bias(self._handle, rates.tobytes())
            load = tau - self._C
            M, J = self._mass_matrix(at), self.loop_jacobian(at)
            free = np.linalg.solve(M, load)
            if not len(J):
                return np.asarray(free)
            response = np.linalg.solve(M, J.T)
            p = np.linalg.lstsq(J @ response, -self.loop_bias(at, rates) - J @ free, rcond=1e-9)[0]
            return np.asarray(free + response @ p)
        tau = tau - self._stiffness * (at - self._rest)
        self._core.move(self._handle, at.tobytes())
        self._core.accelerate(self._handle, rates.tobytes(), tau.tobytes(), self._armature)
        return self._qdd.copy()

    @property
    def dependent(self) -> BoolArray:
        """Flags of dependent coordinates, shape (n,). Only `IndependentDynamics` has some."""
        return np.zeros(self.n, dtype=np.bool_)

    def closed(self, q: ArrayLike) -> FloatArray:
        """Return the pose with closed loops for the independent coordinates of q, shape (n,).

        Raises:
            InputError: The loops cannot be closed.
        """
        return finite("q", q, self.n).copy()

    def remaining_gap(self, q: ArrayLike) -> float:
        """Return the largest gap of the closed loops, in [m] or [rad]; 0 without loops."""
        return 0.0

    def _mass_matrix(self, q: FloatArray) -> FloatArray:
        self._core.move(self._handle, q.tobytes())
        self._core.update_mass_matrix(self._handle)
        return self._M.copy()

    def _coriolis(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        self._core.move(self._handle, q.tobytes())
        self._core.update_coriolis(self._handle, qd.tobytes())
        return self._C.copy()

    def _gravity(self, q: FloatArray) -> FloatArray:
        self._core.move(self._handle, q.tobytes())
        self._core.update_gravity(self._handle)
        return self._G.copy()
