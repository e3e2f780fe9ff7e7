"""Solvers of quadratic programs: `BoxSolver` with checked solutions, and back ends of qpsolvers."""

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

# Largest relative residual of an accepted solution of a qpsolvers back end.
_MAX_RESIDUAL = 1e-6

# Tolerances are tighter than the defaults of 1e-3 to 1e-6. Iteration limits are necessary, since
# some methods iterate for minutes on an infeasible problem.
_OPTIONS: dict[str, dict[str, Any]] = {
    "clarabel": {"tol_feas": 1e-10, "tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10},
    "osqp": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20000, "polishing": True},
    "piqp": {"eps_abs": 1e-9, "eps_rel": 1e-9},
    "proxqp": {"eps_abs": 1e-9, "eps_rel": 0.0, "max_iter": 300},
    "scs": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iters": 20000},
}


def available_solvers() -> list[str]:
    """Return the sorted names of the installed back ends.

    The first call imports qpsolvers, which takes about 0.3 s. `dual_newton` does not require it.
    """
    import qpsolvers

    return sorted([DUAL_NEWTON, *qpsolvers.available_solvers])


def require_solver(name: str, *, key: str | None = None) -> str:
    """Check that a back end is installed and return its name.

    Args:
        name: `dual_newton`, or the name of a qpsolvers back end.
        key: Settings key that contains the name, for the message.

    Raises:
        UnknownNameError: The back end does not exist or is not installed.
    """
    if name != DUAL_NEWTON and name not in (known := available_solvers()):
        raise UnknownNameError("QP solver", name, known, key=key)
    return name


def solve(problem: qpsolvers.Problem, solver: str) -> FloatArray | None:
    """Solve a QP by a qpsolvers back end, without checking the solution.

    Exceptions and warnings of the back end are ignored, since the caller checks the solution and
    has a fallback.

    Args:
        problem: The quadratic program.
        solver: Name of an installed qpsolvers back end.

    Returns:
        x, shape (number of variables,), or None if the back end returns no solution.
    """
    solution = _attempt(problem, solver)
    return None if solution is None else solution.x


def _attempt(problem: qpsolvers.Problem, solver: str) -> qpsolvers.Solution | None:
    """Return the unchecked solution of a back end, or None if it has no x."""
    import qpsolvers

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solution = qpsolvers.solve_problem(problem, solver, **_OPTIONS.get(solver, {}))
    except Exception:
        return None
    return None if solution.x is None else solution


class BoxSolver:
    """Solver for a sequence of problems of a fixed size, such as in a control loop.

        solver = BoxSolver(n, m_eq)
        solution = solver.solve(BoxProblem(H_diagonal, g, A, b, lb, ub))

    Every solution is checked. If the chosen back end fails, `dual_newton` solves the problem. The
    status `infeasible` always requires a checked certificate.

    `dual_newton` starts from the multipliers of the last solved problem, so that similar problems
    require fewer steps. This changes solutions only by rounding errors. To repeat solutions bit for
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
        """Discard the last multipliers, so that the next solution does not depend on them."""
        self._newton.start[:] = 0.0

    def get_state(self) -> FloatArray:
        """Return the state of the solver: the last multipliers, shape (m_eq,)."""
        return self._newton.start.copy()

    def set_state(self, state: ArrayLike) -> None:
        """Restore a state from `get_state`, so that the following solutions repeat bit for bit.

        Raises:
            InputError: The state has another shape, or is not finite.
        """
        values = np.asarray(state, dtype=np.float64)
        if values.shape != (self.m_eq,) or not np.isfinite(values).all():
            raise InputError(
                f"the state of a solver must be {self.m_eq} finite numbers, not {state!r}"
            )
        self._newton.start[:] = values

    def solve(self, problem: BoxProblem) -> BoxSolution:
        """Solve a problem and check the solution.

        Args:
            problem: A problem of the size of this solver.

        Raises:
            InputError: A shape, cost, weight or bound is invalid.
            SimulationError: A number is not finite.
        """
        self._write_problem(problem)
        answer = None
        if self.solver != DUAL_NEWTON:
            answer = self._solve_by_qpsolvers(problem, self.solver)
        return self._solve_by_dual_newton() if answer is None else answer

    def _write_problem(self, problem: BoxProblem) -> None:
        """Write the problem to the memory of the solver."""
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
            _raise_invalid(newton)
        newton.softness[:] = row_softness(problem)

    def _solve_by_dual_newton(self) -> BoxSolution:
        newton = self._newton
        status = newton.solve()
        if status > dual_newton.NOT_CONVERGED:
            _raise_invalid(newton)
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

    def _solve_by_qpsolvers(self, problem: BoxProblem, solver: str) -> BoxSolution | None:
        """Return the solution of a qpsolvers back end, or None if it fails the check."""
        eps = self._newton.softness
        solution = _attempt(as_qpsolvers(problem, eps), solver)
        if solution is None:
            return None
        x = np.clip(solution.x[: self.n], problem.lb, problem.ub)
        y = None if solution.y is None else -np.asarray(solution.y)
        slack = problem.A @ x - problem.b
        residuals = check(problem, eps, x, y)
        if not residuals.equality <= _MAX_RESIDUAL or residuals.dual > _MAX_RESIDUAL:
            return None
        if y is None:
            y = np.full(self.m_eq, np.nan)
        return BoxSolution(x, y, "solved", slack, 0, False, solver, residuals)


_STATUS: dict[int, Status] = {
    dual_newton.SOLVED: "solved",
    dual_newton.INFEASIBLE: "infeasible",
    dual_newton.NOT_CONVERGED: "not converged",
}


def _raise_invalid(newton: dual_newton.DualNewton) -> None:
    """Raise an error that names the invalid number of a problem."""
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
            raise InputError(f"lb[{i}] {low} and ub[{i}] {high} must allow a finite number")
    raise SimulationError("a number of the QP is too large or too small for a float when squared")


def as_qpsolvers(
    problem: BoxProblem | dual_newton.DualNewton, eps: FloatArray
) -> qpsolvers.Problem:
    """Convert a QP to qpsolvers, with the variables x, then s of the soft rows. Arrays are copied.

    Args:
        problem: The QP.
        eps: Softness of the rows, shape (m_eq,).
    """
    import qpsolvers

    H, g, A, b, lb, ub = (
        np.array(array)
        for array in (problem.H_diagonal, problem.g, problem.A, problem.b, problem.lb, problem.ub)
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
