"""Cable-length control: set points for position-controlled motors, without joint sensors.

    l0 = l(q_d) - (f_ff - D l_d')/K,   l_d' = L(q_d) qd_d

These set points hold the reference exactly if the robot is at the reference. The feedforward forces
f_ff are the forces of eq. (3) at the reference. Without f_ff, the joints sag until the stretch of
the springs, which is proportional to 1/K, produces these forces. With f_ff, the springs only
compensate model errors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray
from controllers.dynamics import PathDynamics, bias_torque, require_no_motors
from controllers.force_distribution.bounded import ForceDistribution
from controllers.force_distribution.solution import ForceSolution
from controllers.qp import solver as qp
from controllers.validation import MAX_PRETENSION, check_sizes, named_vector

from .motors import SpringMotors


@dataclass(frozen=True)
class CableLengthSolution(ForceSolution):
    """Set points of motors, and the forces that they produce at the reference.

    Attributes:
        set_points: l0, shape (m,), in [m].
    """

    set_points: FloatArray


class CableLengthController:
    """Controller that computes set points of position-controlled motors from a joint reference.

    Args:
        dynamics: Robot model of the controller.
        motors: Motors of the robot.
        pretension: Constant forces instead of f_ff, a number or shape (m,), in [N], for a robot
            with unknown masses (default: f_ff).
        weights: Diagonal of H for f_ff, shape (m,), in [1/N²] (default: ones).
        solver: Name of a QP back end.

    Raises:
        InputError: A constant or weight is invalid, or the muscles of motors and robot differ.
        UnknownNameError: The back end is not installed.

    Attributes:
        distribution: The force distribution for f_ff, with force limits and weights.
    """

    def __init__(
        self,
        dynamics: PathDynamics,
        motors: SpringMotors,
        *,
        pretension: ArrayLike | None = None,
        weights: ArrayLike | None = None,
        solver: str = qp.DEFAULT_SOLVER,
    ) -> None:
        names = dynamics.muscle_names
        if motors.muscle_names != names:
            raise InputError(
                f"the motors are defined for the muscles {motors.muscle_names}, "
                f"but the robot has {names}"
            )
        require_no_motors(dynamics, "cable-length control")
        self.dynamics = dynamics
        self.motors = motors
        self.distribution = ForceDistribution(
            dynamics.f_min,
            dynamics.f_max,
            weights=weights,
            solver=solver,
            coordinate_names=dynamics.coordinate_names,
            muscle_names=names,
        )
        self._pretension = (
            None
            if pretension is None
            else named_vector("pretension", pretension, names, upper=MAX_PRETENSION)
        )

    def solve(
        self,
        q: FloatArray,
        qd: FloatArray,
        q_d: FloatArray,
        qd_d: FloatArray,
        qdd_d: FloatArray,
        *,
        w_e: FloatArray | None = None,
    ) -> CableLengthSolution:
        """Compute the set points for the reference at one time.

        Args:
            q: Not used, since this controller has no feedback.
            qd: Not used.
            q_d: Desired positions, shape (n,), in [rad] or [m].
            qd_d: Desired velocities, shape (n,), in [rad/s] or [m/s].
            qdd_d: Desired accelerations, shape (n,), in [rad/s²] or [m/s²].
            w_e: Generalised external load to compensate, shape (n,), in [N·m] or [N], or None.

        Raises:
            InputError: A vector has another size.
            SimulationError: The reference is not finite.
        """
        robot = self.dynamics
        names = robot.coordinate_names
        check_sizes(names, q_d=q_d, qd_d=qd_d, qdd_d=qdd_d, w_e=w_e)
        L = robot.muscle_jacobian(q_d)
        tau = robot.mass_matrix(q_d) @ qdd_d + bias_torque(robot, q_d, qd_d)
        forward = self._feedforward(L, tau if w_e is None else tau + w_e)
        set_points = self.motors.set_points(robot.muscle_lengths(q_d), L @ qd_d, forward.forces)
        return CableLengthSolution(**vars(forward), set_points=set_points)

    def _feedforward(self, L: FloatArray, tau: FloatArray) -> ForceSolution:
        """Return f_ff, or the pretension with zero slack, since no torque is required."""
        if self._pretension is None:
            return self.distribution.solve(L, tau)
        robot = self.dynamics
        return ForceSolution(
            self._pretension.copy(),
            "solved",
            np.zeros_like(tau),
            robot.f_min.copy(),
            robot.f_max.copy(),
            robot.coordinate_names,
            robot.muscle_names,
        )
