"""Force distribution: the muscle forces of least cost that make a joint torque.

    min 1/2 (f - f_p)'H (f - f_p)   s.t.   -L'f = tau,   f_min <= f <= f_max

or those of another norm of H^1/2 (f - f_p), see `norms`. f_p is 0, or a pretension.
Motors of joints are among the forces, behind the muscles: their torques may be negative.

When no force fits, the soft problem is solved instead: the smallest error within the bounds,
    min 1/2 |W (L'f + tau)|^2 + eps/2 (f - f_p)'H (f - f_p)   s.t.   f_min <= f <= f_max,
with W = 1 for the torque's error, or M^-1 for that of the acceleration.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, SimulationError
from controllers.arrays import FloatArray
from controllers.qp import dual_newton
from controllers.qp import solver as qp
from controllers.validation import (
    LARGEST_PRETENSION,
    float_array,
    force_bounds,
    is_finite,
    named_vector,
    require_norm,
)

from .solution import ForceSolution, Status

if TYPE_CHECKING:
    import qpsolvers

_Answer = tuple[FloatArray, FloatArray, float]  # forces, slack, largest |slack|

_SOFTNESS = 1e-8  # eps, relative to the size of LL'


def _accelerations(
    L: FloatArray, tau: FloatArray, M: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """L M^-1 and M^-1 tau, so that the error of the one counts what that of the other makes."""
    if M is None:
        return L, tau
    made = np.asarray(np.linalg.solve(M, np.column_stack([L.T, tau])), dtype=np.float64)
    return np.ascontiguousarray(made[:, :-1].T), made[:, -1]


class ForceDistribution:
    """Distributes joint torques over muscles.

    Args:
        f_min: Lower bounds, shape (m,), in [N].
        f_max: Upper bounds, shape (m,), in [N]; may be infinite.
        weights: Diagonal of H, shape (m,), in [1/N²]; ones when None.
        norm: What is made least, a whole number from 1 to 8, or infinity.
        pretension: f_p, a number or shape (m,), in [N].
        solver: `dual_newton`, or the name of a qpsolvers back end.
        tolerance: Largest torque error of a solved problem, relative to 1 + max |tau|.
        coordinate_names: n names for reports; numbered when None.
        muscle_names: m names for reports; numbered when None.
        motors: How many of the last of the forces are torques of motors, which may be negative.

    Raises:
        InputError: A bound, weight or tolerance is wrong; the message names it.
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
        self._newtons: tuple[()] | tuple[dual_newton.DualNewton, dual_newton.DualNewton] = ()
        self.set_bounds(f_min, f_max)
        # Only the ratios of weights matter; near 1 they suit every back end's tolerances.
        self._weights = self.weights / self.weights.mean()
        self._H = np.diag(self._weights)
        self.norm = require_norm(norm)
        self.pretension = named_vector(
            "pretension", pretension, self.muscle_names, most=LARGEST_PRETENSION
        )
        self._g = self._weights * (0.0 - self.pretension)
        if self.coordinate_names:
            self._prepare(len(self.coordinate_names))

    def set_bounds(self, f_min: ArrayLike, f_max: ArrayLike) -> None:
        """Change the bounds.

        Args:
            f_min: Lower bounds, shape (m,), in [N].
            f_max: Upper bounds, shape (m,), in [N]; may be infinite.

        Raises:
            InputError: A bound is wrong; the message names the muscle.
        """
        sizes = {np.shape(f_min), np.shape(f_max), self.weights.shape, (len(self.muscle_names),)}
        if len(sizes) != 1 or not self.weights.size:
            raise InputError("f_min, f_max, weights and names must be equally long vectors")
        low, high = force_bounds(self.muscle_names, f_min, f_max, self._motors)
        for name, weight in zip(self.muscle_names, self.weights, strict=True):
            if not (np.isfinite(weight) and weight > 0):
                raise InputError(f"muscle {name!r}: weight {weight} must be finite and positive")
        self.f_min: FloatArray = low
        self.f_max: FloatArray = high
        for newton in self._newtons:
            newton.lb[:], newton.ub[:] = low, high

    def build_problem(self, L: FloatArray, tau: FloatArray) -> qpsolvers.Problem:
        """The QP, apart from its solution.

        Args:
            L: Muscle Jacobian, shape (m, n), in [m/rad] or [m/m].
            tau: Desired torque, shape (n,), in [N·m] or [N].
        """
        import qpsolvers  # late, as in controllers.qp.solver

        return qpsolvers.Problem(self._H, self._g, A=-L.T, b=tau, lb=self.f_min, ub=self.f_max)

    def build_soft_problem(
        self, L: FloatArray, tau: FloatArray, M: FloatArray | None = None
    ) -> qpsolvers.Problem:
        """The QP that always has a solution: the smallest error within the bounds.

        Args:
            L: Muscle Jacobian, shape (m, n), in [m/rad] or [m/m].
            tau: Desired torque, shape (n,), in [N·m] or [N].
            M: As for `solve`.
        """
        import qpsolvers

        L, tau = _accelerations(L, tau, M)
        softness = self._softness(L)
        P, g = L @ L.T + softness * self._H, L @ tau + softness * self._g
        return qpsolvers.Problem(P, g, lb=self.f_min, ub=self.f_max)

    def reset(self) -> None:
        """Forget the last solutions: the next does not depend on anything before it."""
        for newton in self._newtons:
            newton.start[:] = 0.0

    def get_state(self) -> FloatArray:
        """All that is remembered between solutions: shape (2n,).

        Without coordinate names n is not known before the first solution, and the shape is (0,).
        """
        return np.concatenate([newton.start for newton in self._newtons] or [np.empty(0)])

    def set_state(self, state: ArrayLike) -> None:
        """Go back to what `get_state` gave; the following solutions repeat bit for bit.

        Args:
            state: From `get_state`.

        Raises:
            InputError: It has another shape, or is not finite.
        """
        values = float_array("the state", state)
        if values.ndim != 1 or values.size % 2 or not np.isfinite(values).all():
            raise InputError(f"a force distribution's state is 2n finite numbers, not {state!r}")
        if not values.size:
            self.reset()
            return
        hard, soft = self._prepare(values.size // 2)
        hard.start[:], soft.start[:] = np.split(values, 2)

    def solve(self, L: FloatArray, tau: FloatArray, M: FloatArray | None = None) -> ForceSolution:
        """Forces that make the torque, or come as near as the bounds allow.

        The answer of the back end is checked, whatever its status; where it fails the check, the
        default back end and DAQP follow. Answers depend on earlier ones by rounding
        errors at most; see `get_state`.

        Args:
            L: Muscle Jacobian, shape (m, n), in [m/rad] or [m/m].
            tau: Desired torque, shape (n,), in [N·m] or [N].
            M: Mass matrix, shape (n, n). With it, the error that is made smallest where no force
                fits is that of the joints' acceleration, M^-1 (tau + L'f); without it, that of the
                torque. The first lets a robot come back to its reference.

        Raises:
            InputError: L or tau has another shape.
            SimulationError: L or tau is not finite.
        """
        L, tau = np.asarray(L, dtype=np.float64), np.asarray(tau, dtype=np.float64)
        squares = self._least_squares(L, tau, M)
        if self.norm == 2.0 or squares.status != "solved":
            return squares
        from .norms import least_norm  # late: SciPy takes its time

        forces = least_norm(
            *(-L.T, tau, self.f_min, self.f_max),
            norm=self.norm,
            weights=self._weights,
            target=self.pretension,
            first=squares.forces,
        )
        if forces is None:
            return replace(squares, status="not converged")
        forces = np.clip(forces, self.f_min, self.f_max)
        slack = tau + L.T @ forces
        allowed = self.tolerance * (1.0 + float(np.abs(tau).max()))
        fits = float(np.abs(slack).max()) <= allowed
        return self._solution(forces, "solved" if fits else "not converged", slack)

    def _least_squares(self, L: FloatArray, tau: FloatArray, M: FloatArray | None) -> ForceSolution:
        """The forces of least squares, or of the smallest error."""
        if L.shape != (self.f_min.size, tau.size) or tau.ndim != 1 or not tau.size:
            raise InputError(
                f"L has shape {L.shape}, tau {tau.shape}, for {self.f_min.size} muscles"
            )
        hard, soft = self._prepare(tau.size)
        allowed = self.tolerance * (1.0 + float(np.abs(tau).max()))
        if self.solver != qp.DUAL_NEWTON:
            self._require_finite(L, tau)
            chosen = self._try_qpsolvers(self.build_problem(L, tau), self.solver, L, tau)
            if chosen is not None and chosen[2] <= allowed:
                return self._solution(chosen[0], "solved", chosen[1])
        status, answer = self._try_dual_newton(hard, L, tau)
        if status == dual_newton.NOT_CONVERGED:
            answer = self._try_fallbacks(self.build_problem(L, tau), L, tau, allowed)
        if answer is not None and answer[2] <= allowed:
            return self._solution(answer[0], "solved", answer[1])
        forces, slack = self._least_error(soft, L, tau, M)
        if float(np.abs(slack).max()) <= allowed:
            return self._solution(forces, "solved", slack)
        proven = status == dual_newton.INFEASIBLE or self._is_infeasible(L, tau)
        return self._solution(forces, "soft" if proven else "not converged", slack)

    def _is_infeasible(self, L: FloatArray, tau: FloatArray) -> bool:
        """What a linear programme says, where there is no certificate."""
        from .feasibility import is_infeasible  # late: SciPy takes its time

        return is_infeasible(-L.T, tau, self.f_min, self.f_max)

    def _least_error(
        self,
        newton: dual_newton.DualNewton,
        L: FloatArray,
        tau: FloatArray,
        M: FloatArray | None,
    ) -> tuple[FloatArray, FloatArray]:
        """Forces within the bounds whose error is smallest, and what is missing."""
        rows, goal = _accelerations(L, tau, M)
        newton.softness[:] = self._softness(rows)
        _, answer = self._try_dual_newton(newton, rows, goal)
        if answer is None:
            problem = self.build_soft_problem(L, tau, M)
            answer = self._try_fallbacks(problem, L, tau, np.inf)
        if answer is None:
            raise SimulationError(f"no forces found for the torque {tau} within the bounds")
        return answer[0], tau + L.T @ answer[0]

    def _softness(self, L: FloatArray) -> float:
        """The eps of the soft problem."""
        size = float(np.sum(L * L)) / float(self._weights.sum())
        return _SOFTNESS * max(size, float(np.finfo(float).tiny) / _SOFTNESS)

    def _prepare(self, n: int) -> tuple[dual_newton.DualNewton, dual_newton.DualNewton]:
        """The solvers of the hard and the soft problem for n coordinates."""
        if not self._newtons or self._newtons[0].b.size != n:
            m = self.f_min.size
            self._newtons = dual_newton.DualNewton(m, n), dual_newton.DualNewton(m, n)
            for newton in self._newtons:
                newton.H_diagonal[:], newton.g[:] = self._weights, self._g
                newton.lb[:], newton.ub[:] = self.f_min, self.f_max
        return self._newtons

    def _try_dual_newton(
        self, newton: dual_newton.DualNewton, L: FloatArray, tau: FloatArray
    ) -> tuple[int, _Answer | None]:
        """The status, and forces, slack and largest error if it is solved."""
        np.negative(L.T, out=newton.A)
        newton.b[:] = tau
        status = newton.solve()
        if status != dual_newton.SOLVED:
            if status > dual_newton.NOT_CONVERGED:
                self._require_finite(L, tau)
                raise SimulationError("the muscle Jacobian or a weight is too large for a float")
            return status, None
        slack = -newton.slack
        return status, (newton.x.copy(), slack, float(np.abs(slack).max()))

    def _try_qpsolvers(
        self, problem: qpsolvers.Problem, solver: str, L: FloatArray, tau: FloatArray
    ) -> _Answer | None:
        """Forces, clipped to the bounds, slack and largest error; None without an answer."""
        found = qp.solve(problem, solver)
        if found is None:
            return None
        forces = np.clip(found, self.f_min, self.f_max)
        slack = tau + L.T @ forces
        return forces, slack, float(np.abs(slack).max())

    def _try_fallbacks(
        self, problem: qpsolvers.Problem, L: FloatArray, tau: FloatArray, allowed: float
    ) -> _Answer | None:
        """The first answer of a back end with an error that is allowed; None if there is none."""
        answers = (self._try_qpsolvers(problem, name, L, tau) for name in qp.fallbacks())
        return next((a for a in answers if a is not None and a[2] <= allowed), None)

    @staticmethod
    def _require_finite(L: FloatArray, tau: FloatArray) -> None:
        if not (np.isfinite(tau).all() and np.isfinite(L).all()):
            raise SimulationError("the desired torque or the muscle Jacobian is not finite")

    def _solution(self, forces: FloatArray, status: Status, slack: FloatArray) -> ForceSolution:
        names = self.coordinate_names or tuple(f"coordinate {k + 1}" for k in range(slack.size))
        bounds = self.f_min.copy(), self.f_max.copy()
        return ForceSolution(forces, status, slack, *bounds, names, self.muscle_names)
