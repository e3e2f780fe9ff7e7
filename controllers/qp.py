"""Quadratic programs: one kind solved here, accurately and checked; others by qpsolvers, by name.

The kind solved here has a diagonal cost, equalities and bounds:

    min 1/2 x'Hx + g'x + 1/2 sum_j s_j²/eps_j   s.t.   A x - s = b,   lb <= x <= ub

with H diagonal and positive. A row with eps_j = 0 is hard: its slack s_j is zero. Describe the
program by a `BoxProblem` and give it to a `BoxSolver`.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import qpsolvers
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot import InputError, SimulationError, UnknownNameError

from . import dual_newton

FloatArray = NDArray[np.float64]
Status = Literal["solved", "infeasible", "not converged"]

DUAL_NEWTON = "dual_newton"
FALLBACK = "daqp"
DEFAULT_SOLVER = DUAL_NEWTON
SOFTNESS = 1e-4

# What a qpsolvers back end answers is believed if its relative residuals are below this.
_BELIEVED = 1e-6

# A row's terms below this share of the largest row's are not compared with themselves.
_LEAST_ROW = 1e-8

# First-order and interior-point methods stop at 1e-3 to 1e-6 unless told otherwise, and some go on
# for minutes on a problem that has no solution.
_OPTIONS: dict[str, dict[str, Any]] = {
    "clarabel": {"tol_feas": 1e-10, "tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10},
    "osqp": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20000, "polishing": True},
    "piqp": {"eps_abs": 1e-9, "eps_rel": 1e-9},
    "proxqp": {"eps_abs": 1e-9, "eps_rel": 0.0, "max_iter": 300},
    "scs": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iters": 20000},
}


def available_solvers() -> list[str]:
    """Names of the back ends that can be used, sorted."""
    return sorted([DUAL_NEWTON, *qpsolvers.available_solvers])


def require_solver(name: str, *, key: str | None = None) -> str:
    """The name, if there is such a back end.

    Args:
        name: `dual_newton`, or the name of a qpsolvers back end.
        key: Where the name comes from, for the message.

    Raises:
        UnknownNameError: It is not installed or does not exist.
    """
    known = available_solvers()
    if name not in known:
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
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solution = qpsolvers.solve_problem(problem, solver, **_OPTIONS.get(solver, {}))
    except Exception:
        return None
    x = solution.x
    return x if x is not None and np.all(np.isfinite(x)) else None


@dataclass(frozen=True, eq=False)
class BoxProblem:
    """A QP with a diagonal cost, equalities that may be soft, and bounds.

        min 1/2 x'Hx + g'x + 1/2 sum_j s_j²/eps_j   s.t.   A x - s = b,   lb <= x <= ub

    Units: with the cost in [c], x_i in [u_i] and row j in [r_j], H is in [c/u²], g in [c/u],
    A in [r/u], b and s in [r]. The answer does not depend on these units beyond rounding.

    Attributes:
        H_diagonal: Diagonal of H, shape (n,), finite and positive.
        g: Linear cost, shape (n,).
        A: Equalities, shape (m_eq, n), in any memory layout; rows may depend on each other.
        b: Their right sides, shape (m_eq,).
        lb: Lower bounds, shape (n,); -inf where there is none.
        ub: Upper bounds, shape (n,); inf where there is none, equal to lb for a fixed variable.
        row_weights: Shape (m_eq,), without unit: inf for a hard row, positive and finite for a soft
            one. All rows are hard when None.
        softness: The eps of a soft row of weight 1, relative to the problem's scale: eps_j =
            softness · scale / row_weights_j, where scale is the mean of diag(A H⁻¹ A') over the
            soft rows. Rows of different units want weights of their own. The default bends a
            solution that exists by about 1e-4 of itself; a smaller one bends it less.
    """

    H_diagonal: FloatArray
    g: FloatArray
    A: FloatArray
    b: FloatArray
    lb: FloatArray
    ub: FloatArray
    row_weights: FloatArray | None = None
    softness: float = SOFTNESS


@dataclass(frozen=True)
class Residuals:
    """How well a solution fulfils the optimality conditions, each relative to what is added up.

    Attributes:
        equality: Largest |A x - s - b| of a row, relative to |b_j| + |s_j| + sum_i |A_ji x_i|.
        dual: Largest |x - clip(H⁻¹ (A'y - g), lb, ub)| of a variable, relative to |x_i| and the
            terms before clipping. NaN if the back end gave no multipliers.
        bounds: Largest violation of a bound.
    """

    equality: float
    dual: float
    bounds: float


@dataclass(frozen=True, eq=False)
class BoxSolution:
    """An answer to a `BoxProblem`; the arrays are the caller's own.

    Attributes:
        x: Shape (n,), always within the bounds. Without meaning unless `solved`.
        multipliers: y, shape (m_eq,), with Hx + g - A'y = 0 for variables off their bounds, and
            s_j = -eps_j y_j for soft rows. If `infeasible`, the certificate: a direction y with
            y'b > y'Ax for every x within the bounds.
        status: `solved`: the residuals were checked. `infeasible`: no x fulfils the hard rows, and
            the certificate was checked. `not converged`: neither could be shown.
        slack: A x - b, shape (m_eq,): of a soft row its slack s_j, of a hard one what rounding
            leaves.
        iterations: Newton steps; 0 if another back end answered.
        fell_back: The wanted back end gave no answer that stood the check, so another was asked.
        solver: Name of the back end that answered.
        residuals: What the check found.
    """

    x: FloatArray
    multipliers: FloatArray
    status: Status
    slack: FloatArray
    iterations: int
    fell_back: bool
    solver: str
    residuals: Residuals


def row_softness(problem: BoxProblem) -> FloatArray:
    """The eps of every row, shape (m_eq,): 0 for hard rows.

    Raises:
        InputError: A weight or the softness is not positive.
    """
    rows = len(problem.b)
    if problem.row_weights is None:
        return np.zeros(rows)
    weights = np.asarray(problem.row_weights, dtype=np.float64)
    if weights.shape != (rows,):
        raise InputError(f"row_weights has shape {weights.shape}, not ({rows},)")
    if not (weights > 0).all():
        j = int(np.argmin(weights > 0))
        raise InputError(f"row_weights[{j}] {weights[j]} must be positive, inf for a hard row")
    if not 0 < problem.softness < np.inf:
        raise InputError(f"softness {problem.softness} must be finite and positive")
    soft = np.isfinite(weights)
    if not soft.any():
        return np.zeros(rows)
    A = np.asarray(problem.A, dtype=np.float64)[soft]
    scale = float(((A * A) @ (1.0 / np.asarray(problem.H_diagonal))).mean())
    eps: FloatArray = problem.softness * (scale or 1.0) / weights
    return eps


class BoxSolver:
    """Solves problems of one size again and again, as a controller does.

        solver = BoxSolver(n, m_eq)
        solution = solver.solve(BoxProblem(H_diagonal, g, A, b, lb, ub))

    Every answer is checked, whoever gave it. Where the wanted back end fails, `dual_newton` is
    asked, and then DAQP.

    `dual_newton` remembers the multipliers of the last solved problem: the next, if it is near,
    takes fewer steps. This changes an answer by rounding errors at most; who must repeat answers
    bit for bit saves and restores `get_state`, or calls `reset` before every problem.

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
        """All that the solver remembers: the last multipliers, shape (m_eq,)."""
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
        """The checked answer.

        Args:
            problem: Of this solver's size.

        Raises:
            InputError: A shape, cost, weight or bound is wrong.
            SimulationError: A number is not finite.
        """
        self._hand_over(problem)
        answer: BoxSolution | None = None
        if self.solver != DUAL_NEWTON:
            answer = self._ask_qpsolvers(problem, self.solver)
        if answer is None:
            answer = self._ask_dual_newton()
        if answer.status == "not converged":
            answer = self._ask_qpsolvers(problem, FALLBACK) or answer
        return answer

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

    def _ask_dual_newton(self) -> BoxSolution:
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

    def _ask_qpsolvers(self, problem: BoxProblem, solver: str) -> BoxSolution | None:
        """A qpsolvers back end's answer, or None if it gave none that stands the check."""
        eps = self._newton.softness
        x, y = _ask_qpsolvers(problem, eps, solver)
        if x is None:
            return None
        slack = problem.A @ x - problem.b
        residuals = check(problem, eps, x, y)
        if not residuals.equality <= _BELIEVED or residuals.dual > _BELIEVED:
            return None
        if y is None:
            y = np.full(self.m_eq, np.nan)
        fell_back = solver != self.solver
        return BoxSolution(x, y, "solved", slack, 0, fell_back, solver, residuals)


_STATUS: dict[int, Status] = {
    dual_newton.SOLVED: "solved",
    dual_newton.INFEASIBLE: "infeasible",
    dual_newton.NOT_CONVERGED: "not converged",
}


def _refuse(newton: dual_newton.DualNewton) -> None:
    """Say which number of a refused problem is wrong."""
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


def as_qpsolvers(problem: BoxProblem, eps: FloatArray) -> qpsolvers.Problem:
    """The same program for qpsolvers, with variables [x, s of the soft rows].

    Args:
        problem: The program.
        eps: Softness of the rows, shape (m_eq,).
    """
    soft = np.flatnonzero(eps > 0)
    P = np.diag(np.concatenate([problem.H_diagonal, 1.0 / eps[soft]]))
    selection = np.zeros((len(eps), len(soft)))
    selection[soft, np.arange(len(soft))] = -1.0
    free = np.full(len(soft), np.inf)
    return qpsolvers.Problem(
        P,
        np.concatenate([problem.g, np.zeros(len(soft))]),
        A=np.hstack([problem.A, selection]),
        b=problem.b,
        lb=np.concatenate([problem.lb, -free]),
        ub=np.concatenate([problem.ub, free]),
    )


def _ask_qpsolvers(
    problem: BoxProblem, eps: FloatArray, solver: str
) -> tuple[FloatArray | None, FloatArray | None]:
    """A qpsolvers back end's x, within the bounds, and multipliers; None for what it gave not."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solution = qpsolvers.solve_problem(
                as_qpsolvers(problem, eps), solver, **_OPTIONS.get(solver, {})
            )
    except Exception:
        return None, None
    if solution.x is None or not np.isfinite(solution.x).all():
        return None, None
    x = np.clip(solution.x[: len(problem.g)], problem.lb, problem.ub)
    return x, None if solution.y is None else -np.asarray(solution.y)


def check(problem: BoxProblem, eps: FloatArray, x: FloatArray, y: FloatArray | None) -> Residuals:
    """How well x and the multipliers y fulfil the optimality conditions.

    Args:
        problem: The program.
        eps: Softness of the rows, shape (m_eq,).
        x: Shape (n,).
        y: Multipliers, shape (m_eq,); None if they are unknown.
    """
    A, b, H, g = problem.A, problem.b, problem.H_diagonal, problem.g
    outside = float(max(np.maximum(problem.lb - x, x - problem.ub).max(), 0.0))
    norms = np.sqrt((A * A / H).sum(axis=1))
    norms[norms == 0.0] = norms.max() or 1.0
    rest = (A @ x - b) / norms
    size = (np.abs(b) + np.abs(A) @ np.abs(x)) / norms
    size += _LEAST_ROW * size.max()
    if y is None:
        hard = eps == 0
        return Residuals(_relative(rest[hard], size[hard]), float("nan"), outside)
    wanted = np.clip((A.T @ y - g) / H, problem.lb, problem.ub)
    terms = np.abs(x) + (np.abs(g) + np.abs(A).T @ np.abs(y)) / H
    return Residuals(
        _relative(rest + eps * y / norms, size + np.abs(eps * y) / norms),
        _relative(x - wanted, terms),
        outside,
    )


def _relative(rest: FloatArray, size: FloatArray) -> float:
    """Largest |rest| / size, where nothing of nothing is nothing."""
    tiny = float(np.finfo(float).tiny)
    return float((np.abs(rest) / np.maximum(size, tiny)).max(initial=0.0))
