"""Cable-velocity control: rates of motor set points from joint errors.

    l0' = L(q) (qd_d + Kp (q_d - q) + Kd (qd_d - qd))

This law extends `CableLengthController` and `CableLengthVelocityController` of kindyn. Those use
only one column of L for each joint, define the error with the opposite sign, and do not use qd_d,
so that they lag behind moving targets. The law requires no robot model except L. If the motors
integrate l0', a constant error changes the set points continuously. Under a constant load the
joints therefore converge to q_d.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import SimulationError
from controllers.arrays import FloatArray
from controllers.dynamics import Dynamics, require_no_motors
from controllers.validation import check_sizes, named_vector


@dataclass(frozen=True, eq=False)
class CableVelocitySolution:
    """Rates of set points.

    Attributes:
        rates: l0', shape (m,), in [m/s]; negative when a motor shortens its cable.
        muscle_names: m names.
    """

    rates: FloatArray
    muscle_names: tuple[str, ...]


class CableVelocityController:
    """Controller that computes rates of motor set points from joint errors.

    Args:
        dynamics: Robot model of the controller; only L is used.
        kp: Gain on the position error, a number or shape (n,), in [1/s].
        kd: Gain on the velocity error, a number or shape (n,), dimensionless. With kp = 0 and
            without feedforward, this is the velocity controller of kindyn.
        feedforward: Whether to add qd_d. The controllers of kindyn do not add it.

    Raises:
        InputError: A gain is negative or not finite, or the number of gains is wrong.

    Attributes:
        kp, kd: The gains, shape (n,).
    """

    def __init__(
        self,
        dynamics: Dynamics,
        kp: ArrayLike,
        kd: ArrayLike = 0.0,
        *,
        feedforward: bool = True,
    ) -> None:
        require_no_motors(dynamics, "cable-velocity control")
        self.dynamics = dynamics
        self.kp = named_vector("kp", kp, dynamics.coordinate_names)
        self.kd = named_vector("kd", kd, dynamics.coordinate_names)
        self._feedforward = feedforward

    def solve(
        self,
        q: FloatArray,
        qd: FloatArray,
        q_d: FloatArray,
        qd_d: FloatArray,
        qdd_d: FloatArray | None = None,
    ) -> CableVelocitySolution:
        """Compute the rates of the set points.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            q_d: Desired positions, shape (n,).
            qd_d: Desired velocities, shape (n,).
            qdd_d: Not used.

        Raises:
            InputError: A vector has another size.
            SimulationError: The state or the reference is not finite.
        """
        check_sizes(self.dynamics.coordinate_names, q=q, qd=qd, q_d=q_d, qd_d=qd_d)
        desired = self.kp * (q_d - q) + self.kd * (qd_d - qd)
        if self._feedforward:
            desired = desired + qd_d
        rates = self.dynamics.muscle_jacobian(q) @ desired
        if not np.isfinite(rates).all():
            raise SimulationError("the state or the reference of the controller is not finite")
        return CableVelocitySolution(rates, self.dynamics.muscle_names)
