"""Back ends of qpsolvers for quadratic programs."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from addin_sdfusion.robot import UnknownNameError
from controllers.arrays import FloatArray

from .dual_newton import DualNewton

if TYPE_CHECKING:
    import qpsolvers

DUAL_NEWTON = "dual_newton"
DEFAULT_SOLVER = DUAL_NEWTON

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


def require_solver(name: str) -> str:
    """Check that a back end is installed and return its name.

    Args:
        name: `dual_newton`, or the name of a qpsolvers back end.

    Raises:
        UnknownNameError: The back end does not exist or is not installed.
    """
    if name != DUAL_NEWTON and name not in (known := available_solvers()):
        raise UnknownNameError("QP solver", name, known)
    return name


def solve(problem: qpsolvers.Problem, solver: str) -> FloatArray | None:
    """Solve a QP by a qpsolvers back end, without checking the solution.

    Exceptions and warnings of the back end are ignored, since the caller checks the solution and
    has a fallback.

    Args:
        solver: Name of an installed qpsolvers back end.

    Returns:
        x, shape (number of variables,), or None if the back end returns no solution.
    """
    import qpsolvers

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solution = qpsolvers.solve_problem(problem, solver, **_OPTIONS.get(solver, {}))
    except Exception:
        return None
    x: FloatArray | None = solution.x
    return x


def as_qpsolvers(problem: DualNewton) -> qpsolvers.Problem:
    """Return a copy of a QP for qpsolvers, with the variables x, then s of the soft rows."""
    import qpsolvers

    eps = problem.softness
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
