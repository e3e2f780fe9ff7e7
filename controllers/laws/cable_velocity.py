"""Cable-velocity control: rates of the motors' set points, from the joints' errors.

    l0' = L(q) (qd_d + Kp (q_d - q) + Kd (qd_d - qd))

After kindyn's `CableLengthController` and `CableLengthVelocityController`, which use one column of
L for each joint by itself and no qd_d: there moving targets are followed late. Their error is of
the other sign. No model is needed but L. Where the motors integrate l0', a standing error keeps
winding: under a constant load the joints come to rest at q_d.
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
        rates: l0', shape (m,), in [m/s]; negative if a motor winds up.
        muscle_names: m names.
    """

    rates: FloatArray
    muscle_names: tuple[str, ...]


class CableVelocityController:
    """Rates of the set points of motors from the joints' errors.

    Args:
        dynamics: The robot as the controller knows it; only its L counts.
        kp: Gain on the error, a number or shape (n,), in [1/s].
        kd: Gain on the error's rate, a number or shape (n,), without unit. With kp = 0 and no
            feedforward this is kindyn's velocity controller.
        feedforward: Whether qd_d itself counts; kindyn's does not have it.

    Raises:
        InputError: A gain is negative or not finite, or there are too many or too few.

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
        require_no_motors(dynamics, "rates of set points of cables")
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
        """Return the rates.

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
