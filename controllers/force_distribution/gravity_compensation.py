"""Forces of muscles, and torques of motors, that hold a robot at rest."""

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
    """Return the smallest forces that balance gravity at rest, -L'f = G(q), within the bounds.

    Where none do, those that come nearest.

    Args:
        dynamics: Dynamics of the robot.
        q: Its positions, shape (n,), in [rad] or [m].
        f_min: Lower bounds, shape (a,), in [N] and [N·m]; those of the dynamics when None.
        f_max: Upper bounds, shape (a,); those of the dynamics when None.

    Returns:
        f, shape (a,), in [N] and, of motors, [N·m].
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
