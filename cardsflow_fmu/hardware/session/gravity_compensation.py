"""The forces that hold a robot where it is: what a ramp begins at, so that nothing falls."""

from __future__ import annotations

from addin_sdfusion.robot import Robot
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import ForceDistribution
from sim_dart import DartDynamics


def holding_forces(robot: Robot, q: FloatArray) -> FloatArray:
    """The smallest forces that balance gravity at rest, -L'f = G(q), within the bounds.

    Where none do, those that come nearest.

    Args:
        robot: The robot.
        q: Where it is, shape (n,), in [rad] or [m].

    Returns:
        f, shape (m,), in [N].
    """
    dynamics = DartDynamics(robot)
    distribution = ForceDistribution(
        dynamics.f_min,
        dynamics.f_max,
        coordinate_names=dynamics.coordinate_names,
        muscle_names=dynamics.muscle_names,
    )
    L = dynamics.muscle_jacobian(q)
    return distribution.solve(L, dynamics.gravity(q), dynamics.mass_matrix(q)).forces
