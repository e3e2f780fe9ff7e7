"""The force QP in single precision: feasible problems are solved, certificates are correct.

The number of problems of each kind is CARDSFLOW_QP_PROBLEMS (default: 500):

    CARDSFLOW_QP_PROBLEMS=10000 python -m pytest -n 0 -s tests/native/test_float_programs.py
"""

from __future__ import annotations

import os
from collections import Counter
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from support.controllers.box_solver import BoxProblem
from support.controllers.qp_problems import KINDS, is_proof_of_infeasibility
from support.native.precision import Precision, open_program

from controllers.qp.dual_newton import INFEASIBLE, NOT_CONVERGED, SOLVED

pytestmark = pytest.mark.slow

COUNT = int(os.environ.get("CARDSFLOW_QP_PROBLEMS", "500"))
WITH_SOLUTION = ("feasible", "at_bounds", "rank_deficient")
FloatArray = NDArray[np.float64]

ROWS = 1e-4
"""Tolerance of a row of a solved problem, relative to its terms."""

ROUNDING = 5e-7

UNDECIDED = 0.01
"""Maximum share of infeasible problems that stay undecided, since they are almost feasible."""


class Answer(NamedTuple):
    """Answer of a solver."""

    status: int
    x: FloatArray
    multipliers: FloatArray


def solve(precision: Precision, problem: BoxProblem, softness: float = 0.0) -> Answer:
    """Solve in that precision, without a warm start."""
    handle = open_program(precision, len(problem.g), len(problem.b))
    for name in ("H_diagonal", "g", "lb", "ub", "b"):
        handle.array(name)[:] = getattr(problem, name)
    handle.array("A")[:] = problem.A.T.ravel()
    handle.array("softness")[:] = softness
    handle.array("start")[:] = 0.0
    status = handle.call("solve")
    return Answer(status, *(handle.array(n).astype(float) for n in ("x", "multipliers")))


def row_error(problem: BoxProblem, x: FloatArray) -> float:
    """Return the maximum error of a row, relative to its terms, without rounding errors.

    Rows are compared in the scale of the solver, where H is the identity and rows have length 1.
    """
    norms = np.linalg.norm(problem.A / np.sqrt(problem.H_diagonal), axis=1)
    norms[norms == 0] = 1.0
    terms = (np.abs(problem.b) + np.abs(problem.A) @ np.abs(x)) / norms
    off = np.abs(problem.A @ x - problem.b) / norms - ROUNDING * terms.max()
    return float((off / np.where(terms > 0, terms, 1.0)).max())


@pytest.mark.parametrize("kind", WITH_SOLUTION)
def test_feasible_problems_are_solved(kind: str, single: Precision, double: Precision) -> None:
    """Rows hold, bounds hold exactly, and most solutions equal those of double precision."""
    off, rows = [], []
    for seed in range(COUNT):
        problem = KINDS[kind](seed)
        answer, true = solve(single, problem), solve(double, problem)
        assert (seed, answer.status) == (seed, SOLVED)
        low, high = (np.asarray(b, np.float32) for b in (problem.lb, problem.ub))
        assert (answer.x >= low).all(), seed
        assert (answer.x <= high).all(), seed
        rows.append(row_error(problem, answer.x))
        off.append(np.abs(answer.x - true.x).max() / np.abs(true.x).max().clip(1e-9))
    print(f"\n{kind}: {COUNT} solved; errors of rows {max(rows):.0e} at most; of x", end=" ")
    print(f"{np.median(off):.0e} in the median, {np.quantile(off, 0.99):.0e} for 99 %")
    assert max(rows) < 1.01 * ROWS
    assert np.median(off) < 1e-6
    assert np.quantile(off, 0.99) < 1e-4


def test_solved_infeasible_problems_are_almost_feasible(single: Precision) -> None:
    """Certificates are proofs in exact arithmetic; otherwise rows hold up to rounding."""
    found: Counter[int] = Counter()
    for seed in range(COUNT):
        problem = KINDS["infeasible"](seed)
        answer = solve(single, problem)
        found[answer.status] += 1
        if answer.status == INFEASIBLE:
            assert is_proof_of_infeasibility(problem, answer.multipliers), seed
        elif answer.status == SOLVED:
            assert row_error(problem, answer.x) < 1.01 * ROWS, seed
    print(
        f"\n{found[INFEASIBLE]} proven, {found[SOLVED]} solved within {ROWS} of the rows'", end=" "
    )
    print(f"terms, {found[NOT_CONVERGED]} undecided")
    assert set(found) <= {INFEASIBLE, SOLVED, NOT_CONVERGED}
    assert found[INFEASIBLE] > 0.9 * COUNT
    assert found[NOT_CONVERGED] < UNDECIDED * COUNT


@pytest.mark.parametrize("softness", [1e-4, 1.0])
def test_soft_problems_are_always_solved(
    softness: float, single: Precision, double: Precision
) -> None:
    off = []
    for seed in range(COUNT // 2):
        problem = KINDS["infeasible" if seed % 2 else "feasible"](seed)
        scale = (problem.A**2 / problem.H_diagonal).sum() / len(problem.b)
        answer = solve(single, problem, softness * scale)
        true = solve(double, problem, softness * scale)
        assert (seed, answer.status, true.status) == (seed, SOLVED, SOLVED)
        off.append(np.abs(answer.x - true.x).max() / np.abs(true.x).max().clip(1e-9))
    print(f"\nx deviates by {np.median(off):.0e} in the median, {max(off):.0e} at most")
    assert np.median(off) < 1e-6
    assert np.quantile(off, 0.99) < 1e-5
    assert max(off) < 5e-2
