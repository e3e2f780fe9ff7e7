"""Back ends for quadratic programs: any of qpsolvers, by name, asked for accurate solutions."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import qpsolvers
from numpy.typing import NDArray

from addin_sdfusion.robot import UnknownNameError

FloatArray = NDArray[np.float64]

DEFAULT_SOLVER = "daqp"

# First-order and interior-point methods stop at 1e-3 to 1e-6 unless told otherwise, and some go on
# for minutes on a problem that has no solution.
_OPTIONS: dict[str, dict[str, Any]] = {
    "clarabel": {"tol_feas": 1e-10, "tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10},
    "osqp": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iter": 20000, "polishing": True},
    "piqp": {"eps_abs": 1e-9, "eps_rel": 1e-9},
    "proxqp": {"eps_abs": 1e-9, "eps_rel": 0.0, "max_iter": 300},
    "scs": {"eps_abs": 1e-9, "eps_rel": 1e-9, "max_iters": 20000},
}


def require_solver(name: str, *, key: str | None = None) -> str:
    """The name, if qpsolvers has that back end installed.

    Args:
        name: Name of a qpsolvers back end.
        key: Where the name comes from, for the message.

    Raises:
        UnknownNameError: It is not installed or does not exist.
    """
    if name not in qpsolvers.available_solvers:
        raise UnknownNameError("QP solver", name, sorted(qpsolvers.available_solvers), key=key)
    return name


def solve(problem: qpsolvers.Problem, solver: str) -> FloatArray | None:
    """The back end's answer, shape (number of variables,), unchecked; None if it gave none.

    Whatever the back end raises or warns of counts as no answer: the caller checks the answer by
    itself and has a fallback.

    Args:
        problem: The quadratic program.
        solver: Name of an installed back end.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            solution = qpsolvers.solve_problem(problem, solver, **_OPTIONS.get(solver, {}))
    except Exception:
        return None
    x = solution.x
    return x if x is not None and np.all(np.isfinite(x)) else None
