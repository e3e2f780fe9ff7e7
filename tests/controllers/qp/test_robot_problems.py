"""Verify the status of force QPs of random robots."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from support.controllers import robot_problems
from support.controllers.box_solver import BoxProblem, BoxSolution, BoxSolver, solve
from support.controllers.robot_problems import (
    AT_THE_EDGE,
    EXACT,
    is_certificate,
    is_feasible,
    is_infeasible,
)

from controllers.qp import dual_newton

pytestmark = pytest.mark.native


class Verdicts:
    """Statuses of the dual Newton method."""

    def __init__(self) -> None:
        self._solvers: dict[tuple[int, ...], BoxSolver] = {}
        self.last: BoxSolution | None = None

    def __call__(self, problem: BoxProblem) -> BoxSolution:
        m_eq, n = problem.A.shape
        solver = self._solvers.setdefault((m_eq, n), BoxSolver(n, m_eq))
        solver.reset()
        self.last = solver.answer(problem)
        return self.last

    def is_feasible(self, problem: BoxProblem) -> bool:
        """Return whether the last problem is feasible."""
        assert self.last is not None
        return self.last.status != "infeasible"


def test_every_status_for_random_robots_is_correct() -> None:
    """Rows or certificates hold, and a linear program agrees if it is conclusive.

    A few problems at the boundary of feasibility remain undecided due to rounding errors.
    """
    verdicts, found, rows = Verdicts(), Counter[str](), [0.0]
    for k, problem in enumerate(robot_problems.robot_problems(verdicts.is_feasible)):
        answer = verdicts(problem)
        found[answer.status] += 1
        assert np.isfinite([answer.residuals.equality, answer.residuals.dual]).all(), k
        assert np.isfinite(answer.x).all(), k
        if answer.status == "solved":
            rows.append(robot_problems.row_error(problem, answer.x))
            assert rows[-1] <= AT_THE_EDGE, k
        elif answer.status == "infeasible":
            assert is_certificate(problem, answer.multipliers), k
        if k % 50 == 0 or answer.status == "not converged":
            feasible, infeasible = is_feasible(problem), is_infeasible(problem)
            assert not (answer.status == "solved" and infeasible), k
            assert not (answer.status == "infeasible" and feasible), k
            found["at the edge"] += not (feasible or infeasible)
    edge = found.pop("at the edge", 0)
    inexact = int(np.sum(np.array(rows) > 1e-9))
    print(
        f"{dict(found)}; rows off by {max(rows):.0e} at most, {inexact} by more than 1e-9; ", end=""
    )
    print(f"{edge} of the problems solved by HiGHS are at the boundary of feasibility")
    assert found["solved"] > 0.3 * found.total()
    assert found["infeasible"] > 0.3 * found.total()
    assert found["not converged"] <= 2e-4 * found.total()
    assert inexact <= 1e-3 * found.total()


def test_difficult_feasible_problems_are_solved(shared: Path) -> None:
    """The robots have 6 to 9 coordinates and accelerations of thousands of rad/s²."""
    for case in json.loads((shared / "reference/qp/feasible_unsolved.json").read_text()):
        given = ("H_diagonal", "g", "A", "b", "lb", "ub")
        problem = BoxProblem(*(np.array(case["problem"][name], float) for name in given))
        answer = solve(problem)
        assert answer.status == "solved"
        assert robot_problems.row_error(problem, answer.x) <= EXACT


def test_results_of_an_undecided_problem_are_finite() -> None:
    """The coefficients exceed the precision of floats, but no result is NaN."""
    rng = np.random.default_rng(0)
    for _ in range(300):
        n, m_eq = int(rng.integers(2, 12)), int(rng.integers(1, 8))
        A = rng.normal(size=(m_eq, n)) * 10.0 ** rng.uniform(-14, 14, (m_eq, n))
        H, lb = 10.0 ** rng.uniform(-12, 12, n), rng.normal(size=n) * 10.0 ** rng.uniform(-9, 9, n)
        ub = lb + 10.0 ** rng.uniform(-9, 9, n)
        problem = BoxProblem(H, np.zeros(n), A, A @ ub * rng.uniform(0.5, 1.5), lb, ub)
        newton = solve(problem)
        assert newton.status in ("solved", "infeasible", "not converged")
        assert np.isfinite(newton.x).all()
        assert np.isfinite(newton.multipliers).all()
        assert not np.isnan([newton.residuals.equality, newton.residuals.dual]).any()
        if newton.status == "infeasible":
            assert is_certificate(problem, newton.multipliers)


def test_status_numbers_match_c() -> None:
    assert (dual_newton.SOLVED, dual_newton.INFEASIBLE, dual_newton.NOT_CONVERGED) == (0, 1, 2)
