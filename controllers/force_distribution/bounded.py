"""Force distribution: muscle forces of minimum cost that produce a joint torque.

    min 1/2 (f - f_p)'H (f - f_p)   s.t.   -L'f = tau,   f_min <= f <= f_max

Another norm of H^1/2 (f - f_p) can be minimised instead. If the minimum is not unique, the solution
nearest to f_p is used. f_p is a pretension (default: 0). The vector f contains muscle forces,
followed by motor torques, which may be negative.

If the problem is infeasible, the soft problem minimises the error within the force limits:
    min 1/2 |W (L'f + tau)|^2 + eps/2 (f - f_p)'H (f - f_p)   s.t.   f_min <= f <= f_max,
where W = 1 weights the torque error and W = M^-1 weights the acceleration error.

The file csrc/laws/distribution.c implements the solution.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, SimulationError
from controllers.arrays import FloatArray
from controllers.qp import law_in_c
from controllers.qp import solver as qp
from controllers.validation import (
    MAX_PRETENSION,
    float_array,
    force_bounds,
    is_finite,
    named_vector,
    require_norm,
)

from .solution import STATUSES, ForceSolution

if TYPE_CHECKING:
    import qpsolvers


class ForceDistribution:
    """Distribution of joint torques over muscles.

    Args:
        f_min: Lower force limits, shape (m,), in [N].
        f_max: Upper force limits, shape (m,), in [N]; may be infinite.
        weights: Diagonal of H, shape (m,), in [1/N²] (default: ones).
        norm: Norm to minimise, an integer from 1 to 8, or infinity.
        pretension: f_p, a number or shape (m,), in [N].
        solver: `dual_newton`, or the name of a qpsolvers back end.
        tolerance: Largest torque error of a solved problem, relative to 1 + max |tau|.
        coordinate_names: n names for messages (default: `coordinate 1`, ...).
        muscle_names: m names for messages (default: `muscle 1`, ...).
        motors: Number of motors. Their torques are the last forces and may be negative.

    Raises:
        InputError: A limit, weight or tolerance is invalid; the message names it.
        UnknownNameError: The back end is not installed.
    """

    def __init__(
        self,
        f_min: ArrayLike,
        f_max: ArrayLike,
        *,
        weights: ArrayLike | None = None,
        norm: float = 2.0,
        pretension: ArrayLike = 0.0,
        solver: str = qp.DEFAULT_SOLVER,
        tolerance: float = 1e-6,
        coordinate_names: Sequence[str] | None = None,
        muscle_names: Sequence[str] | None = None,
        motors: int = 0,
    ) -> None:
        m = np.size(f_min)
        self._motors = motors
        self.weights: FloatArray = float_array(
            "weights", np.ones(m) if weights is None else weights
        )
        self.solver = qp.require_solver(solver)
        if not (is_finite(tolerance) and tolerance > 0):
            raise InputError(f"tolerance must be positive and finite, not {tolerance!r}")
        self.tolerance = tolerance
        self.coordinate_names = None if coordinate_names is None else tuple(coordinate_names)
        numbered = tuple(f"muscle {k + 1}" for k in range(m))
        self.muscle_names = numbered if muscle_names is None else tuple(muscle_names)
        self._law: law_in_c.LawInC | None = None
        self.set_bounds(f_min, f_max)
        self.norm = require_norm(norm)
        self.pretension = named_vector(
            "pretension", pretension, self.muscle_names, upper=MAX_PRETENSION
        )
        if self.coordinate_names:
            self.law(len(self.coordinate_names))

    def set_bounds(self, f_min: ArrayLike, f_max: ArrayLike) -> None:
        """Change the force limits.

        Args:
            f_min: Lower limits, shape (m,), in [N].
            f_max: Upper limits, shape (m,), in [N]; may be infinite.

        Raises:
            InputError: A limit is invalid; the message names the muscle.
        """
        sizes = {np.shape(f_min), np.shape(f_max), self.weights.shape, (len(self.muscle_names),)}
        if len(sizes) != 1 or not self.weights.size:
            raise InputError("f_min, f_max, weights and names must have equal lengths above 0")
        low, high = force_bounds(self.muscle_names, f_min, f_max, self._motors)
        for name, weight in zip(self.muscle_names, self.weights, strict=True):
            if not (np.isfinite(weight) and weight > 0):
                raise InputError(f"muscle {name!r}: weight {weight} must be finite and positive")
        self.f_min: FloatArray = low
        self.f_max: FloatArray = high
        if self._law is not None:
            self._law.write(f_min=low, f_max=high)

    def law(self, n: int) -> law_in_c.LawInC:
        """Return the C implementation for n coordinates. It distributes a given torque."""
        if self._law is None or self._law["tau"].size != n:
            self._law = law_in_c.LawInC(n, self.f_min.size)
            self._law.write(
                law=law_in_c.GIVEN,
                H_f=self.weights,
                f_p=self.pretension,
                norm=self.norm,
                tolerance=self.tolerance,
                f_min=self.f_min,
                f_max=self.f_max,
            )
            self._law.reset()
        return self._law

    def build_problem(self, L: FloatArray, tau: FloatArray) -> qpsolvers.Problem:
        """Return the QP without solving it.

        Args:
            L: Muscle Jacobian, shape (m, n), in [m/rad] or [m/m].
            tau: Desired torque, shape (n,), in [N·m] or [N].
        """
        return self._write_problem(L, tau, None).build()

    def reset(self) -> None:
        """Discard previous solutions, so that the next solution does not depend on them."""
        if self._law is not None:
            self._law.reset()

    def get_state(self) -> FloatArray:
        """Return the state of the solver between solutions, shape (2n,).

        Without coordinate names, n is unknown before the first solution. The shape is then (0,).
        """
        return np.empty(0) if self._law is None else self._law["memory"][self.f_min.size :].copy()

    def set_state(self, state: ArrayLike) -> None:
        """Restore a state, so that the following solutions repeat bit for bit.

        Args:
            state: Result of `get_state`.

        Raises:
            InputError: The state has another shape, or is not finite.
        """
        values = float_array("the state", state)
        if values.ndim != 1 or values.size % 2 or not np.isfinite(values).all():
            raise InputError(
                f"the state of a force distribution must be 2n finite numbers, not {state!r}"
            )
        if values.size:
            self.law(values.size // 2)["memory"][self.f_min.size :] = values
        else:
            self.reset()

    def solve(self, L: FloatArray, tau: FloatArray, M: FloatArray | None = None) -> ForceSolution:
        """Compute forces that produce the torque, or approximate it within the force limits.

        Every solution of a back end is checked, regardless of its status. If it fails the check,
        the default back end solves the problem. Previous solutions affect a solution only by
        rounding errors; see `get_state`.

        Args:
            L: Muscle Jacobian, shape (m, n), in [m/rad] or [m/m].
            tau: Desired torque, shape (n,), in [N·m] or [N].
            M: Mass matrix, shape (n, n). If the problem is infeasible, the solution minimises the
                error of the joint acceleration, M^-1 (tau + L'f), so that a robot can return to its
                reference. Without M, it minimises the torque error.

        Raises:
            InputError: L or tau has another shape.
            SimulationError: L or tau is not finite.
        """
        return self.solve_law(self._write_problem(L, tau, M))

    def _write_problem(self, L: ArrayLike, tau: ArrayLike, M: FloatArray | None) -> law_in_c.LawInC:
        L, tau = np.asarray(L, dtype=np.float64), np.asarray(tau, dtype=np.float64)
        if L.shape != (self.f_min.size, tau.size) or tau.ndim != 1 or not tau.size:
            raise InputError(
                f"L has shape {L.shape}, tau {tau.shape}, for {self.f_min.size} muscles"
            )
        law = self.law(tau.size)
        M = np.eye(tau.size) if M is None else M
        law.write(law=law_in_c.GIVEN, L=L, tau=tau, M=M, passive=0.0)
        return law

    def solve_law(self, law: law_in_c.LawInC) -> ForceSolution:
        """Solve the problem in `law` and return the forces; raises the errors of `solve`."""
        status = law.solve(self.solver)
        if status >= law_in_c.FAILED:
            tau = law["tau"]
            if not (np.isfinite(tau).all() and np.isfinite(law["L"]).all()):
                raise SimulationError("the desired torque or the muscle Jacobian is not finite")
            if status == law_in_c.WRONG:
                raise SimulationError("the muscle Jacobian or a weight is too large for a float")
            raise SimulationError(f"no forces within the limits found for the torque {tau}")
        slack = law["slack"].copy()
        names = self.coordinate_names or tuple(f"coordinate {k + 1}" for k in range(slack.size))
        bounds = self.f_min.copy(), self.f_max.copy()
        forces = law["forces"].copy()
        return ForceSolution(forces, STATUSES[status], slack, *bounds, names, self.muscle_names)
