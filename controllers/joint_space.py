"""Computed torque in joint space, eq. (3) of the CARDSFlow paper.

min 1/2 f'Hf
s.t. M(q)(qdd_d + Kd (qd_d - qd) + Kp (q_d - q)) + C(q, qd) + G(q) = -L(q)'f,
     f_min <= f <= f_max
"""

from __future__ import annotations

import numpy as np
import qpsolvers
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot import InputError

from . import qp
from .dynamics import Dynamics
from .force_distribution import ForceDistribution, ForceSolution

FloatArray = NDArray[np.float64]


def gain_vector(name: str, gain: ArrayLike, coordinate_names: tuple[str, ...]) -> FloatArray:
    """A gain for every coordinate, shape (n,), from a number or a vector.

    Args:
        name: Name of the gain, for the message.
        gain: A number for all coordinates, or one each.
        coordinate_names: n names.

    Raises:
        InputError: A gain is negative or not finite, or there are too many or too few.
    """
    n = len(coordinate_names)
    try:
        gains = np.array(np.broadcast_to(np.asarray(gain, dtype=np.float64), (n,)))
    except (TypeError, ValueError):
        raise InputError(f"{name} must be a number or {n} numbers, not {gain!r}") from None
    for coordinate, value in zip(coordinate_names, gains, strict=True):
        if not (np.isfinite(value) and value >= 0):
            raise InputError(f"{name} of {coordinate!r} must be finite and not negative: {value}")
    return gains


class JointSpaceController:
    """Computed-torque control of joint positions through muscle forces.

    Args:
        dynamics: The robot as the controller knows it.
        kp: Position gain Kp, a number or shape (n,), in [1/s²].
        kd: Velocity gain Kd, a number or shape (n,), in [1/s].
        weights: Diagonal of H, shape (m,), in [1/N²]; ones when None.
        solver: Name of a qpsolvers back end.

    Raises:
        InputError: A gain, bound or weight is wrong.
        UnknownNameError: The back end is not installed.

    Attributes:
        kp, kd: The gains, shape (n,).
        distribution: The force distribution, with bounds and weights.
    """

    def __init__(
        self,
        dynamics: Dynamics,
        kp: ArrayLike,
        kd: ArrayLike,
        *,
        weights: ArrayLike | None = None,
        solver: str = qp.DEFAULT_SOLVER,
    ) -> None:
        self.dynamics = dynamics
        self.set_gains(kp, kd)
        self.distribution = ForceDistribution(
            dynamics.f_min,
            dynamics.f_max,
            weights=weights,
            solver=solver,
            coordinate_names=dynamics.coordinate_names,
            muscle_names=dynamics.muscle_names,
        )

    def set_gains(self, kp: ArrayLike, kd: ArrayLike) -> None:
        """Change the gains.

        Args:
            kp: Position gain, a number or shape (n,), in [1/s²].
            kd: Velocity gain, a number or shape (n,), in [1/s].

        Raises:
            InputError: A gain is negative or not finite, or there are too many or too few.
        """
        self.kp = gain_vector("kp", kp, self.dynamics.coordinate_names)
        self.kd = gain_vector("kd", kd, self.dynamics.coordinate_names)

    def required_torque(
        self,
        q: FloatArray,
        qd: FloatArray,
        q_d: FloatArray,
        qd_d: FloatArray,
        qdd_d: FloatArray,
    ) -> FloatArray:
        """The left side of eq. (3), and the joints' damping: the torque that the muscles must make.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            q_d: Desired positions, shape (n,).
            qd_d: Desired velocities, shape (n,).
            qdd_d: Desired accelerations, shape (n,), in [rad/s²] or [m/s²].

        Returns:
            tau, shape (n,), in [N·m] or [N].
        """
        robot = self.dynamics
        M, C, G, D = robot.mass_matrix(q), robot.coriolis(q, qd), robot.gravity(q), robot.damping
        a = qdd_d + self.kd * (qd_d - qd) + self.kp * (q_d - q)
        tau: FloatArray = M @ a + C + G + D * qd
        return tau

    def build_problem(
        self,
        q: FloatArray,
        qd: FloatArray,
        q_d: FloatArray,
        qd_d: FloatArray,
        qdd_d: FloatArray,
    ) -> qpsolvers.Problem:
        """Eq. (3) as a QP, apart from its solution. Arguments as in `required_torque`."""
        tau = self.required_torque(q, qd, q_d, qd_d, qdd_d)
        return self.distribution.build_problem(self.dynamics.muscle_jacobian(q), tau)

    def solve(
        self,
        q: FloatArray,
        qd: FloatArray,
        q_d: FloatArray,
        qd_d: FloatArray,
        qdd_d: FloatArray,
    ) -> ForceSolution:
        """The forces of eq. (3), checked. Arguments as in `required_torque`.

        Raises:
            SimulationError: The state or the reference is not finite.
        """
        tau = self.required_torque(q, qd, q_d, qd_d, qdd_d)
        return self.distribution.solve(self.dynamics.muscle_jacobian(q), tau)
