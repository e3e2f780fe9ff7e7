"""Muscle forces and motor torques that hold a robot at rest."""

from __future__ import annotations

from numpy.typing import ArrayLike

from controllers.arrays import FloatArray
from controllers.dynamics import Dynamics, actuator_names

from .bounded import ForceDistribution


def gravity_compensation(
    dynamics: Dynamics,
    q: FloatArray,
    f_min: ArrayLike | None = None,
    f_max: ArrayLike | None = None,
) -> FloatArray:
    """Compute the smallest forces within the limits that balance gravity, -L'f = G(q).

    If this is infeasible, return the forces with the smallest acceleration error.

    Args:
        q: Joint positions, shape (n,), in [rad] or [m].
        f_min: Lower limits, shape (a,), in [N] and [N·m] (default: the limits of the robot).
        f_max: Upper limits, shape (a,), in [N] and [N·m] (default: the limits of the robot).

    Returns:
        f, shape (a,), in [N] for muscles and [N·m] for motors.
    """
    distribution = ForceDistribution(
        dynamics.f_min if f_min is None else f_min,
        dynamics.f_max if f_max is None else f_max,
        coordinate_names=dynamics.coordinate_names,
        muscle_names=actuator_names(dynamics),
        motors=len(dynamics.motor_names),
    )
    L = dynamics.actuator_jacobian(q)
    return distribution.solve(L, dynamics.gravity(q), dynamics.mass_matrix(q)).forces
