"""Computed torque in joint space, eq. (3) of the CARDSFlow paper.

min 1/2 (f - f_p)'H (f - f_p)
s.t. M(q)(qdd_d + Kd (qd_d - qd) + Kp (q_d - q)) + C(q, qd) + G(q) + w_e = -L(q)'f,
     f_min <= f <= f_max

If no forces within the limits exist, the controller minimises the acceleration error.

Passive coordinates do not follow the reference. Springs, dampers and the motion of the other
coordinates drive them. The passive rows of the equation of motion are used to eliminate the passive
accelerations from the active rows. With active coordinates a and passive coordinates p, M, tau and
L become

    M_aa - M_ap M_pp⁻¹ M_pa,   tau_a - M_ap M_pp⁻¹ tau_p,   L_a - L_p M_pp⁻¹ M_pa

The files csrc/laws/joint/joint_space.c and csrc/laws/distribution.c implement the computation.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import UnknownNameError
from controllers.arrays import FloatArray
from controllers.dynamics import Dynamics, actuator_names, bias_torque
from controllers.force_distribution.bounded import ForceDistribution
from controllers.force_distribution.solution import ForceSolution
from controllers.qp import law_in_c
from controllers.qp import solver as qp
from controllers.validation import check_sizes, named_vector

from .joint_laws import JOINT_LAWS

if TYPE_CHECKING:
    import qpsolvers

_State = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""q, qd, q_d, qd_d and qdd_d of `JointSpaceController.solve`."""


class JointSpaceController:
    """Computed-torque control of joint positions through muscle forces.

    Other native laws replace the left side of eq. (3) by another formula for the torque. A derived
    class can override `required_torque` with a formula in Python. The same QP distributes the
    torque over the muscles.

    Args:
        dynamics: Robot model of the controller.
        kp: Position gain Kp, a number or shape (n,), in [1/s²].
        kd: Velocity gain Kd, a number or shape (n,), in [1/s].
        weights: Diagonal of H, shape (a,), in [1/N²] for muscles and [1/(N·m)²] for motors
            (default: ones).
        norm: Norm of H^1/2 (f - f_p) to minimise, an integer from 1 to 8, or infinity.
        pretension: f_p, a number or shape (a,), in [N] and [N·m].
        solver: Name of a qpsolvers back end.
        passive: Whether each coordinate is passive, shape (n,) (default: all are active).
        law: Name of a law in `JOINT_LAWS`, which also defines the units of the gains.

    Raises:
        InputError: A gain, limit or weight is invalid.
        UnknownNameError: The law does not exist, or the back end is not installed.

    Attributes:
        kp, kd: The gains, shape (n,).
        distribution: The force distribution, with force limits, weights and the back end.
    """

    def __init__(
        self,
        dynamics: Dynamics,
        kp: ArrayLike,
        kd: ArrayLike,
        *,
        weights: ArrayLike | None = None,
        norm: float = 2.0,
        pretension: ArrayLike = 0.0,
        solver: str = qp.DEFAULT_SOLVER,
        passive: ArrayLike | None = None,
        law: str = "joint_space",
    ) -> None:
        self.dynamics = dynamics
        laws = [definition.name for definition in JOINT_LAWS]
        if law not in laws:
            raise UnknownNameError("control law", law, laws)
        names = dynamics.coordinate_names
        chosen = np.zeros(len(names)) if passive is None else np.asarray(passive)
        check_sizes(names, passive=chosen)
        self.set_gains(kp, kd)
        self.distribution = ForceDistribution(
            dynamics.f_min,
            dynamics.f_max,
            weights=weights,
            norm=norm,
            pretension=pretension,
            solver=solver,
            coordinate_names=names,
            muscle_names=actuator_names(dynamics),
            motors=len(dynamics.motor_names),
        )
        self._law = self.distribution.law(len(names))
        self._passive = chosen != 0
        self._number = law_in_c.number_of(law)

    @property
    def solver(self) -> str:
        """Name of the back end that solves the QP."""
        return self.distribution.solver

    @solver.setter
    def solver(self, name: str) -> None:
        self.distribution.solver = qp.require_solver(name)

    def set_gains(self, kp: ArrayLike, kd: ArrayLike) -> None:
        """Change the gains.

        Args:
            kp: Position gain, a number or shape (n,), in [1/s²].
            kd: Velocity gain, a number or shape (n,), in [1/s].

        Raises:
            InputError: kp is not positive, kd is negative, or the number of gains is wrong.
        """
        self.kp = named_vector("kp", kp, self.dynamics.coordinate_names, above=0.0)
        self.kd = named_vector("kd", kd, self.dynamics.coordinate_names)

    def set_bounds(self, f_min: ArrayLike, f_max: ArrayLike) -> None:
        """Change the force limits; see `ForceDistribution.set_bounds`."""
        self.distribution.set_bounds(f_min, f_max)

    def reset(self) -> None:
        """Discard the warm start of the solver."""
        self.distribution.reset()

    def get_state(self) -> FloatArray:
        """Return the state of the controller, which is the warm start of the solver."""
        return self.distribution.get_state()

    def set_state(self, state: FloatArray) -> None:
        """Restore a state from `get_state`; see `ForceDistribution.set_state`."""
        self.distribution.set_state(state)

    def required_torque(
        self,
        q: FloatArray,
        qd: FloatArray,
        q_d: FloatArray,
        qd_d: FloatArray,
        qdd_d: FloatArray,
        *,
        w_e: FloatArray | None = None,
        correction: FloatArray | None = None,
    ) -> FloatArray:
        """Compute the torque that the muscles must produce.

        This is the left side of eq. (3) plus the torque of the joint damping.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            q_d: Desired positions, shape (n,).
            qd_d: Desired velocities, shape (n,).
            qdd_d: Desired accelerations, shape (n,), in [rad/s²] or [m/s²].
            w_e: Generalised external load, shape (n,), in [N·m] or [N], or None.
            correction: Vector to add to the commanded acceleration, shape (n,), or None. Laws
                without a commanded acceleration add it to the torque.

        Returns:
            tau, shape (n,), in [N·m] or [N].
        """
        self._write_robot(q)
        self._write_law((q, qd, q_d, qd_d, qdd_d), w_e, correction)
        return self._law.required_torque()

    def error(self, q: FloatArray, q_d: FloatArray) -> FloatArray:
        """Return q_d - q, shape (n,), in [rad] or [m]."""
        return q_d - q

    def build_problem(
        self,
        q: FloatArray,
        qd: FloatArray,
        q_d: FloatArray,
        qd_d: FloatArray,
        qdd_d: FloatArray,
        *,
        w_e: FloatArray | None = None,
    ) -> qpsolvers.Problem:
        """Return the QP of eq. (3) without solving it; see `required_torque` for the arguments."""
        self._write((q, qd, q_d, qd_d, qdd_d), w_e, None)
        return self._law.build()

    def solve(
        self,
        q: FloatArray,
        qd: FloatArray,
        q_d: FloatArray,
        qd_d: FloatArray,
        qdd_d: FloatArray,
        *,
        w_e: FloatArray | None = None,
        correction: FloatArray | None = None,
    ) -> ForceSolution:
        """Compute and check the forces of eq. (3); see `required_torque` for the arguments.

        Raises:
            InputError: The length of a vector is wrong.
            SimulationError: The state or the reference is not finite.
        """
        names = self.dynamics.coordinate_names
        check_sizes(names, q=q, qd=qd, q_d=q_d, qd_d=qd_d, qdd_d=qdd_d)
        check_sizes(names, w_e=w_e, correction=correction)
        self._write((q, qd, q_d, qd_d, qdd_d), w_e, correction)
        return self.distribution.solve_law(self._law)

    def _write(self, state: _State, w_e: FloatArray | None, correction: FloatArray | None) -> None:
        """Write all inputs of the law in C, or the torque of an overridden `required_torque`."""
        if type(self).required_torque is JointSpaceController.required_torque:
            self._write_law(state, w_e, correction)
        else:
            tau = self.required_torque(*state, w_e=w_e, correction=correction)
            self._law.write(law=law_in_c.GIVEN, tau=tau)
        self._write_robot(state[0])

    def _write_robot(self, q: FloatArray) -> None:
        robot = self.dynamics
        L = robot.actuator_jacobian(q)
        self._law.write(M=robot.mass_matrix(q), L=L, passive=self._passive)

    def _write_law(
        self, state: _State, w_e: FloatArray | None, correction: FloatArray | None
    ) -> None:
        q, qd, q_d, qd_d, qdd_d = state
        self._law.write(
            law=self._number,
            kp=self.kp,
            kd=self.kd,
            h=bias_torque(self.dynamics, q, qd),
            error=self.error(q, q_d),
            rate_error=qd_d - qd,
            acceleration=qdd_d,
            qd=qd,
            load=w_e,
            correction=correction,
        )
        if self._law.needs_gravity:
            self._law.write(G=self.dynamics.gravity(q))
