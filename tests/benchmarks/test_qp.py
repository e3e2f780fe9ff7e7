"""Speed of QP back ends, as ratios within one run: `pytest tests/benchmarks -s`.

Sizes are variables/rows of robots: muscles/joints for computed torque in joint space, and
(muscles + joints)/(joints + tasks) in operational space. Only installed back ends are measured.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import cycle
from typing import Any

import numpy as np
import pytest
import qpsolvers
from support.controllers.box_solver import BoxProblem, BoxSolver
from support.interleaved import interleaved, record

from controllers import ForceDistribution
from controllers.qp.dual_newton import SOLVED, DualNewton

SIZES = {
    "joint space, 4/2": (4, 2, 0),
    "joint space, 11/4": (11, 4, 0),
    "joint space, 38/8": (38, 8, 0),
    "joint space, 60/20": (60, 20, 0),
    "operational space, 11+4/7": (11, 4, 3),
    "operational space, 60+20/23": (60, 20, 3),
}
RIVALS = [name for name in ("daqp", "quadprog", "proxqp") if name in qpsolvers.available_solvers]
TICKS = 200


def ticks(muscles: int, joints: int, tasks: int) -> list[BoxProblem]:
    """Return the problems of a controller along a smooth motion."""
    rng = np.random.default_rng(muscles)
    L0, L1 = rng.normal(size=(2, muscles, joints)) * 0.05
    J0, phase = rng.normal(size=(tasks, joints)), rng.uniform(0, 6, muscles)
    M = np.eye(joints) + 0.1 * np.ones((joints, joints))
    found = []
    for t in 0.005 * np.arange(TICKS):
        L = L0 + L1 * np.sin(t)
        f = 60.0 + 50.0 * np.sin(2.0 * t + phase)
        bounds = np.full(muscles, 10.0), np.full(muscles, 500.0)
        if not tasks:
            ones, zeros = np.ones(muscles), np.zeros(muscles)
            found.append(BoxProblem(ones, zeros, -L.T, -L.T @ f, *bounds))
            continue
        A = np.block([[M, L.T], [J0, np.zeros((tasks, muscles))]])
        qdd = 0.5 * np.sin(t + np.arange(joints))
        H = np.concatenate([np.ones(joints), np.full(muscles, 1e-6)])
        free = np.full(joints, np.inf)
        lb, ub = np.concatenate([-free, bounds[0]]), np.concatenate([free, bounds[1]])
        g = np.zeros(joints + muscles)
        found.append(BoxProblem(H, g, A, A @ np.concatenate([qdd, f]), lb, ub))
    return found


def next_of(problems: list[BoxProblem]) -> Callable[[], BoxProblem]:
    """Return a function that steps through the problems forwards and backwards."""
    turns: Iterator[BoxProblem] = cycle([*problems, *problems[-2:0:-1]])
    return lambda: next(turns)


def in_c(problems: list[BoxProblem], *, warm: bool) -> Callable[[], object]:
    """Return a call of the library with prepared arrays, without checks and copies."""
    m_eq, n = problems[0].A.shape
    solver, tick = DualNewton(n, m_eq), next_of(problems)
    for name in ("H_diagonal", "g", "lb", "ub"):
        getattr(solver, name)[:] = getattr(problems[0], name)

    def call() -> None:
        problem = tick()
        solver.A[...], solver.b[:] = problem.A, problem.b
        if not warm:
            solver.start[:] = 0.0
        assert solver.solve() == SOLVED

    return call


def through_python(problems: list[BoxProblem], *, warm: bool) -> Callable[[], object]:
    """Return a call of `BoxSolver`, which copies problem and solution."""
    m_eq, n = problems[0].A.shape
    solver, tick = BoxSolver(n, m_eq), next_of(problems)

    def call() -> None:
        if not warm:
            solver.reset()
        assert solver.answer(tick()).status == "solved"

    return call


def through_qpsolvers(problems: list[BoxProblem], name: str) -> Callable[[], object]:
    """Return a call of a back end through qpsolvers, without a check of the solution."""
    tick, options = next_of(problems), {"eps_abs": 1e-9} if name == "proxqp" else {}

    def call() -> None:
        p = tick()
        q = qpsolvers.Problem(np.diag(p.H_diagonal), p.g, A=p.A, b=p.b, lb=p.lb, ub=p.ub)
        assert qpsolvers.solve_problem(q, name, **options).found

    return call


@pytest.mark.parametrize("name", SIZES)
def test_qp_back_ends(benchmark: Any, name: str) -> None:
    """Compare all back ends with `dual_newton`, which starts from the previous multipliers."""
    problems = ticks(*SIZES[name])
    alternatives = {
        "warm": through_python(problems, warm=True),
        "cold": through_python(problems, warm=False),
        "c_warm": in_c(problems, warm=True),
        "c_cold": in_c(problems, warm=False),
        **{rival: through_qpsolvers(problems, rival) for rival in RIVALS},
    }
    benchmark(alternatives["warm"])
    times = interleaved(alternatives, calls=TICKS // 4)
    ratios = {key: value / times["warm"] for key, value in times.items() if key != "warm"}
    record(f"QP, {name}", warm_us=times["warm"] * 1e6, **ratios)
    assert ratios["daqp"] > 1.0


def test_force_distribution(benchmark: Any) -> None:
    """Compare the default back end with DAQP for a tick with 11 muscles on 4 joints."""
    problems = ticks(11, 4, 0)

    def make_call(solver: str) -> Callable[[], object]:
        distribution = ForceDistribution(np.full(11, 10.0), np.full(11, 500.0), solver=solver)
        tick = next_of(problems)

        def call() -> None:
            problem = tick()
            assert distribution.solve(-problem.A.T, problem.b).status == "solved"

        return call

    alternatives = {solver: make_call(solver) for solver in ("dual_newton", "daqp")}
    benchmark(alternatives["dual_newton"])
    times = interleaved(alternatives, calls=TICKS // 4)
    record(
        "force distribution, 11 muscles on 4 joints",
        us_per_tick=times["dual_newton"] * 1e6,
        daqp=times["daqp"] / times["dual_newton"],
    )
    assert times["daqp"] > 1.5 * times["dual_newton"]
