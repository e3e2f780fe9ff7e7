"""Solvers of quadratic programs: a checked one for `BoxProblem`, and qpsolvers for others."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, SimulationError, UnknownNameError
from controllers.arrays import FloatArray

from . import dual_newton
from .problem import BoxProblem, BoxSolution, Residuals, Status, check, row_softness

if TYPE_CHECKING:
    import qpsolvers

DUAL_NEWTON = "dual_newton"
DEFAULT_SOLVER = DUAL_NEWTON

# An answer of a qpsolvers back end is accepted if its relative residuals are below this.
_ACCEPTED = 1e-6

# Tighter than the defaults of 1e-3 to 1e-6, and iteration limits: some methods iterate for minutes
# on a problem that has no solution.
_OPTIONS: dict[str, dict[str, Any]] = {
    "clarabel": {"tol_feas": 1e-10, "tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10},
    "osqp": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20000, "polishing": True},
    "piqp": {"eps_abs": 1e-9, "eps_rel": 1e-9},
    "proxqp": {"eps_abs": 1e-9, "eps_rel": 0.0, "max_iter": 300},
    "scs": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iters": 20000},
}


def available_solvers() -> list[str]:
    """Return names of the back ends that can be used, sorted.

    The first call imports qpsolvers, which takes a third of a second: dual_newton does without.
    """
    import qpsolvers

    return sorted([DUAL_NEWTON, *qpsolvers.available_solvers])


def require_solver(name: str, *, key: str | None = None) -> str:
    """Return the name, if there is such a back end.

    Args:
        name: `dual_newton`, or the name of a qpsolvers back end.
        key: Where the name comes from, for the message.

    Raises:
        UnknownNameError: It is not installed or does not exist.
    """
    if name != DUAL_NEWTON and name not in (known := available_solvers()):
        raise UnknownNameError("QP solver", name, known, key=key)
    return name


def solve(problem: qpsolvers.Problem, solver: str) -> FloatArray | None:
    """A qpsolvers back end's answer, shape (number of variables,), unchecked; None if it gave none.

    Whatever the back end raises or warns of counts as no answer: the caller checks the answer by
    itself and has a fallback.

    Args:
        problem: The quadratic program.
        solver: Name of an installed qpsolvers back end.
    """
    solution = _attempt(problem, solver)
    return None if solution is None else solution.x


def _attempt(problem: qpsolvers.Problem, solver: str) -> qpsolvers.Solution | None:
    """Return the back end's solution, unchecked, if it has an x."""
    import qpsolvers

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solution = qpsolvers.solve_problem(problem, solver, **_OPTIONS.get(solver, {}))
    except Exception:
        return None
    return None if solution.x is None else solution


class BoxSolver:
    """Solves problems of one size again and again, as a controller does.

        solver = BoxSolver(n, m_eq)
        solution = solver.solve(BoxProblem(H_diagonal, g, A, b, lb, ub))

    Every answer is checked. Where the chosen back end fails, `dual_newton` follows. No back end's
    word is taken for a problem without a solution: `infeasible` is what a certificate proves.

    `dual_newton` remembers the multipliers of the last solved problem: the next, if it is near,
    takes fewer steps. This changes an answer by rounding errors at most; to repeat answers bit for
    bit, save and restore `get_state`, or call `reset` before every problem.

    Args:
        n: Number of variables.
        m_eq: Number of rows of A.
        solver: `dual_newton`, or the name of a qpsolvers back end.

    Raises:
        InputError: A size is not positive, or too large.
        UnknownNameError: The back end is not installed.
    """

    def __init__(self, n: int, m_eq: int, solver: str = DEFAULT_SOLVER) -> None:
        self.n, self.m_eq = n, m_eq
        self.solver = require_solver(solver)
        self._newton = dual_newton.DualNewton(n, m_eq)
        names = ("H_diagonal", "g", "A", "b", "lb", "ub")
        self._inputs = [(name, getattr(self._newton, name)) for name in names]

    def reset(self) -> None:
        """Forget the last multipliers: the next solution does not depend on anything before it."""
        self._newton.start[:] = 0.0

    def get_state(self) -> FloatArray:
        """Return all that the solver remembers: the last multipliers, shape (m_eq,)."""
        return self._newton.start.copy()

    def set_state(self, state: ArrayLike) -> None:
        """Go back to what `get_state` gave; the following answers repeat bit for bit.

        Raises:
            InputError: The state has another shape, or is not finite.
        """
        values = np.asarray(state, dtype=np.float64)
        if values.shape != (self.m_eq,) or not np.isfinite(values).all():
            raise InputError(f"a solver's state is {self.m_eq} finite numbers, not {state!r}")
        self._newton.start[:] = values

    def solve(self, problem: BoxProblem) -> BoxSolution:
        """Return the checked answer.

        Args:
            problem: Of this solver's size.

        Raises:
            InputError: A shape, cost, weight or bound is wrong.
            SimulationError: A number is not finite.
        """
        self._hand_over(problem)
        answer = None
        if self.solver != DUAL_NEWTON:
            answer = self._try_qpsolvers(problem, self.solver)
        return self._try_dual_newton() if answer is None else answer

    def _hand_over(self, problem: BoxProblem) -> None:
        """Write the problem into the solver's own memory."""
        for name, target in self._inputs:
            values = np.asarray(getattr(problem, name))
            if values.shape != target.shape:
                raise InputError(f"{name} has shape {values.shape}, not {target.shape}")
            target[...] = values
        newton = self._newton
        if problem.row_weights is None:
            newton.softness.fill(0.0)
            return
        if not (newton.H_diagonal > 0).all():
            _refuse(newton)
        newton.softness[:] = row_softness(problem)

    def _try_dual_newton(self) -> BoxSolution:
        newton = self._newton
        status = newton.solve()
        if status > dual_newton.NOT_CONVERGED:
            _refuse(newton)
        equality, dual = newton.residuals.tolist()
        return BoxSolution(
            x=newton.x.copy(),
            multipliers=newton.multipliers.copy(),
            status=_STATUS[status],
            slack=newton.slack.copy(),
            iterations=newton.steps,
            fell_back=self.solver != DUAL_NEWTON,
            solver=DUAL_NEWTON,
            residuals=Residuals(equality, dual, 0.0),
        )

    def _try_qpsolvers(self, problem: BoxProblem, solver: str) -> BoxSolution | None:
        """Return a qpsolvers back end's answer, or None if it gave none that passes the check."""
        eps = self._newton.softness
        solution = _attempt(as_qpsolvers(problem, eps), solver)
        if solution is None:
            return None
        x = np.clip(solution.x[: self.n], problem.lb, problem.ub)
        y = None if solution.y is None else -np.asarray(solution.y)
        slack = problem.A @ x - problem.b
        residuals = check(problem, eps, x, y)
        if not residuals.equality <= _ACCEPTED or residuals.dual > _ACCEPTED:
            return None
        if y is None:
            y = np.full(self.m_eq, np.nan)
        return BoxSolution(x, y, "solved", slack, 0, False, solver, residuals)


_STATUS: dict[int, Status] = {
    dual_newton.SOLVED: "solved",
    dual_newton.INFEASIBLE: "infeasible",
    dual_newton.NOT_CONVERGED: "not converged",
}


def _refuse(newton: dual_newton.DualNewton) -> None:
    """Raise the error that names the wrong number of a rejected problem."""
    for name in ("H_diagonal", "g", "A", "b"):
        values = getattr(newton, name)
        if not np.isfinite(values).all():
            raise SimulationError(f"{name} of the QP is not finite")
    for i, (value, low, high) in enumerate(
        zip(newton.H_diagonal, newton.lb, newton.ub, strict=True)
    ):
        if not value > 0:
            raise InputError(f"H_diagonal[{i}] {value} must be positive")
        if not (low <= high and low < np.inf and high > -np.inf):
            raise InputError(
                f"lb[{i}] {low} and ub[{i}] {high} leave no finite number between them"
            )
    raise SimulationError("a number of the QP, squared, is too large or too small for a float")


def as_qpsolvers(
    problem: BoxProblem | dual_newton.DualNewton, eps: FloatArray
) -> qpsolvers.Problem:
    """The same program for qpsolvers, with variables [x, s of the soft rows], in memory of its own.

    Args:
        problem: The program.
        eps: Softness of the rows, shape (m_eq,).
    """
    import qpsolvers

    H, g, A, b, lb, ub = (
        np.array(part)
        for part in (problem.H_diagonal, problem.g, problem.A, problem.b, problem.lb, problem.ub)
    )
    if not eps.any():
        return qpsolvers.Problem(np.diag(H), g, A=A, b=b, lb=lb, ub=ub)
    soft = np.flatnonzero(eps > 0)
    with np.errstate(over="ignore"):
        P = np.diag(np.concatenate([H, 1.0 / eps[soft]]))
    selection = np.zeros((len(eps), len(soft)))
    selection[soft, np.arange(len(soft))] = -1.0
    free = np.full(len(soft), np.inf)
    return qpsolvers.Problem(
        P,
        np.concatenate([g, np.zeros(len(soft))]),
        A=np.hstack([A, selection]),
        b=b,
        lb=np.concatenate([lb, -free]),
        ub=np.concatenate([ub, free]),
    )
