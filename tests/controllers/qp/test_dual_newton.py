from __future__ import annotations

import ctypes
import dataclasses

import numpy as np
import pytest
from support.controllers import qp_problems
from support.controllers.box_solver import (
    BoxProblem,
    BoxSolution,
    BoxSolver,
    residuals_of,
    solve,
)
from support.controllers.qp_problems import (
    FloatArray,
    at_bounds,
    feasible,
    infeasible,
    rank_deficient,
    reference,
)
from support.controllers.robot_problems import row_error

from addin_sdfusion.robot import InputError
from controllers.qp import dual_newton

pytestmark = pytest.mark.native

# Iteration limit of the solver.
MAX_STEPS = 84


class Solvers:
    """Solvers for all problem sizes."""

    def __init__(self) -> None:
        self._solvers: dict[tuple[int, ...], BoxSolver] = {}

    def solve(self, problem: BoxProblem, *, cold: bool) -> BoxSolution:
        m_eq, n = problem.A.shape
        solver = self._solvers.setdefault((m_eq, n), BoxSolver(n, m_eq))
        if cold:
            solver.reset()
        return solver.answer(problem)


def is_within_bounds(problem: BoxProblem, x: FloatArray) -> bool:
    return bool((x >= problem.lb).all() and (x <= problem.ub).all())


def relative_error(x: FloatArray, expected: FloatArray) -> float:
    return float(np.max(np.abs(x - expected) / (1.0 + np.abs(expected))))


@pytest.mark.parametrize("kind", ["feasible", "at_bounds", "rank_deficient"])
def test_random_problems_with_a_solution_are_solved_to_1e_8(kind: str) -> None:
    """Start from zero and from multipliers of another problem; certificates are always correct."""
    solvers, errors, unproven, steps = Solvers(), [0.0], 0, 0
    for seed, problem in enumerate(qp_problems.problems(kind)):
        warm = solvers.solve(problem, cold=False)
        cold = solvers.solve(problem, cold=True)
        assert (seed, cold.status, warm.status) == (seed, "solved", "solved")
        assert all(is_within_bounds(problem, own.x) for own in (warm, cold))
        steps = max(steps, cold.iterations)
        expected = reference(problem, cold)
        if expected is None:
            unproven += 1
            assert cold.residuals.equality <= 1e-13
            assert cold.residuals.dual <= 1e-12
            continue
        errors.append(max(relative_error(cold.x, expected), relative_error(warm.x, expected)))
        assert errors[-1] <= 1e-8, seed
    print(f"{kind}: largest error {max(errors):.2g}, {steps} steps, ", end="")
    print(f"{unproven} without a reference")
    assert steps <= MAX_STEPS
    assert unproven <= 1e-2 * qp_problems.COUNT


def test_random_problems_without_a_solution_are_proven_infeasible() -> None:
    solvers, steps = Solvers(), 0
    for seed, problem in enumerate(qp_problems.problems("infeasible")):
        solution = solvers.solve(problem, cold=True)
        assert (seed, solution.status) == (seed, "infeasible")
        assert qp_problems.is_proof_of_infeasibility(problem, solution.multipliers), seed
        steps = max(steps, solution.iterations)
    print(f"infeasible: {steps} steps")
    assert steps <= MAX_STEPS


@pytest.mark.parametrize("softness", [1e-2, 1e-4, 1e-8])
def test_soft_problems_always_have_a_solution(softness: float) -> None:
    """The solution equals that of the same problem with the slacks as variables."""
    for seed in range(qp_problems.COUNT // 10):
        for kind in (feasible, infeasible, rank_deficient):
            problem = kind(seed)
            scale = np.square(problem.A / np.sqrt(problem.H_diagonal)).sum(axis=1).mean() or 1.0
            eps = softness * scale * np.random.default_rng(seed).uniform(0.5, 2.0, len(problem.b))
            problem = dataclasses.replace(problem, softness=eps)
            solution = solve(problem)
            assert (seed, solution.status) == (seed, "solved")
            assert max(residuals_of(problem, solution.x, solution.multipliers)) < 1e-12
            assert is_within_bounds(problem, solution.x)
            size = np.abs(problem.b) + np.abs(problem.A) @ np.abs(solution.x)
            rest = problem.A @ solution.x - problem.b - solution.slack
            assert (np.abs(rest) <= 1e-13 * size).all()


def test_hard_row_holds_and_soft_row_is_violated() -> None:
    """With x <= 1.5, x1 - x2 = 1/2 is feasible, but x1 + x2 = 4 is infeasible."""
    problem = BoxProblem(
        np.ones(2),
        np.zeros(2),
        np.array([[1.0, 1.0], [1.0, -1.0]]),
        np.array([4.0, 0.5]),
        np.zeros(2),
        np.full(2, 1.5),
        softness=np.array([2e-8, 0.0]),
    )
    solution = solve(problem)
    np.testing.assert_allclose(solution.x, [1.5, 1.0], atol=1e-12)
    np.testing.assert_allclose(solution.slack, [-1.5, 0.0], atol=1e-12)
    assert solve(dataclasses.replace(problem, softness=None)).status == "infeasible"


def test_problem_matches_a_solution_by_hand() -> None:
    """Min 1/2 (x1² + 2 x2² + x3²), x1 + x2 + x3 = 3, x1 <= 1: y = 4/3, x = (1, 2/3, 4/3)."""
    problem = BoxProblem(
        np.array([1.0, 2.0, 1.0]),
        np.zeros(3),
        np.ones((1, 3)),
        np.array([3.0]),
        np.array([-np.inf, 0.0, 0.0]),
        np.array([1.0, np.inf, np.inf]),
    )
    solution = solve(problem)
    np.testing.assert_allclose(solution.x, [1.0, 2 / 3, 4 / 3], rtol=1e-15)
    np.testing.assert_allclose(solution.multipliers, [4 / 3], rtol=1e-14)
    eps = 0.1
    soft = dataclasses.replace(problem, softness=np.array([eps]))
    y = (3.0 - 1.0) / (1.5 + eps)
    solution = solve(soft)
    np.testing.assert_allclose(solution.x, [1.0, y / 2, y], rtol=1e-14)
    np.testing.assert_allclose(solution.slack, [-eps * y], rtol=1e-13)


@pytest.mark.parametrize("kind", [feasible, at_bounds, rank_deficient])
def test_units_and_order_do_not_affect_the_solution(kind: qp_problems.Kind) -> None:
    for seed in range(50):
        problem = kind(seed)
        m_eq, n = problem.A.shape
        rng = np.random.default_rng(seed)
        x = solve(problem).x
        cost, rows, units = 1e7, 10.0 ** rng.uniform(-6, 6, m_eq), 10.0 ** rng.uniform(-4, 4, n)
        scaled = BoxProblem(
            cost * problem.H_diagonal / units**2,
            cost * problem.g / units,
            rows[:, None] * problem.A / units,
            rows * problem.b,
            problem.lb * units,
            problem.ub * units,
        )
        assert relative_error(solve(scaled).x / units, x) < 1e-8
        i, j = rng.permutation(n), rng.permutation(m_eq)
        H, g, lb, ub = (v[i] for v in (problem.H_diagonal, problem.g, problem.lb, problem.ub))
        permuted = BoxProblem(H, g, problem.A[j][:, i], problem.b[j], lb, ub)
        assert relative_error(solve(permuted).x, x[i]) < 1e-8


def test_fixed_variables_and_zero_rows_are_supported() -> None:
    fixed = np.array([1.0, 2.0])
    problem = BoxProblem(
        np.ones(2),
        np.ones(2),
        np.array([[1.0, 1.0], [0.0, 0.0]]),
        np.array([3.0, 0.0]),
        fixed,
        fixed,
    )
    assert solve(problem).x.tolist() == [1.0, 2.0]
    for b in ([3.1, 0.0], [3.0, 0.1]):
        solution = solve(dataclasses.replace(problem, b=np.array(b)))
        assert solution.status == "infeasible"
        assert qp_problems.is_proof_of_infeasibility(problem, solution.multipliers) is False
    nothing = dataclasses.replace(problem, A=np.zeros((2, 2)), b=np.zeros(2), ub=fixed + 1.0)
    assert solve(nothing).x.tolist() == [1.0, 2.0]


def test_certificate_does_not_depend_on_units() -> None:
    """Steps near the solution are short, so that a certificate is checked relative to its size."""
    for scale in (1e-9, 1.0, 1e9):
        for seed in range(50):
            problem = at_bounds(seed)
            problem = dataclasses.replace(problem, A=scale * problem.A, b=scale * problem.b)
            assert solve(problem).status == "solved"
            problem = infeasible(seed)
            problem = dataclasses.replace(problem, A=scale * problem.A, b=scale * problem.b)
            assert solve(problem).status == "infeasible"


def sequence(ticks: int, n: int = 11, m_eq: int = 4) -> list[BoxProblem]:
    """Return the smoothly changing problems of a controller, some of which are infeasible."""
    rng = np.random.default_rng(0)
    L0, L1, phase = rng.normal(size=(m_eq, n)), rng.normal(size=(m_eq, n)), rng.uniform(0, 6, n)
    found = []
    for k in range(ticks):
        A = L0 + 0.3 * np.sin(0.01 * k) * L1
        b = A @ (30.0 + 25.0 * np.sin(0.02 * k + phase)) * (1.0 + 3.0 * (k % 100 > 90))
        bounds = np.full(n, 10.0), np.full(n, 100.0)
        found.append(BoxProblem(np.ones(n), np.zeros(n), A, b, *bounds))
    return found


def test_ticks_repeat_bit_for_bit_from_a_saved_state() -> None:
    ticks = sequence(300)
    solver, other = BoxSolver(11, 4), BoxSolver(11, 4)
    for problem in ticks[:150]:
        solver.answer(problem)
    state = solver.start.copy()
    first = [solver.answer(problem) for problem in ticks[150:]]
    solver.start[:] = other.start[:] = state
    for expected, problem in zip(first, ticks[150:], strict=True):
        for again in (solver.answer(problem), other.answer(problem)):
            assert again.x.tobytes() == expected.x.tobytes()
            assert again.multipliers.tobytes() == expected.multipliers.tobytes()
            assert again.iterations == expected.iterations


def test_warm_start_saves_steps_without_changing_solutions() -> None:
    warm, cold, steps = BoxSolver(11, 4), BoxSolver(11, 4), np.zeros(2)
    for problem in sequence(300):
        cold.reset()
        a, b = warm.answer(problem), cold.answer(problem)
        assert a.status == b.status
        if a.status == "solved":
            assert relative_error(a.x, b.x) < 1e-13
            steps += a.iterations, b.iterations
    assert steps[0] < 0.6 * steps[1]


BASE = {
    "H_diagonal": [1.0, 1.0],
    "g": [0.0, 0.0],
    "A": [[1.0, 1.0]],
    "b": [1.0],
    "lb": [0.0, 0.0],
    "ub": [1.0, 1.0],
}


@pytest.mark.parametrize(
    ("change", "status"),
    [
        ({"g": [0.0, np.nan]}, "wrong cost"),
        ({"H_diagonal": [1.0, np.nan]}, "wrong cost"),
        ({"H_diagonal": [1.0, 0.0]}, "wrong cost"),
        ({"H_diagonal": [-1.0, 1.0]}, "wrong cost"),
        ({"A": [[1.0, np.inf]]}, "wrong rows"),
        ({"b": [np.nan]}, "wrong rows"),
        ({"A": [[1e300, 1.0]]}, "wrong rows"),
        ({"lb": [0.0, 2.0]}, "wrong bounds"),
        ({"lb": [0.0, np.nan]}, "wrong bounds"),
        ({"lb": [0.0, np.inf], "ub": [1.0, np.inf]}, "wrong bounds"),
    ],
)
def test_status_names_the_wrong_part_of_a_problem(
    change: dict[str, list[float]], status: str
) -> None:
    solver = BoxSolver(2, 1)
    wrong, fine = (
        BoxProblem(**{name: np.array(value) for name, value in values.items()})
        for values in (BASE | change, BASE)
    )
    assert solver.answer(wrong).status == status
    assert solver.answer(fine).x.tolist() == [0.5, 0.5]


def test_wrong_sizes_are_rejected() -> None:
    for n, m_eq in ((0, 1), (1, 0), (-1, 1), (5000, 1), (1, 5000)):
        with pytest.raises(InputError, match="too small or too large"):
            BoxSolver(n, m_eq)
    library = dual_newton.library()
    memory = np.empty(library.dual_newton_size(3, 2) // 8 + 1)
    address = memory.ctypes.data
    assert library.dual_newton_open(3, 2, None) is None
    assert library.dual_newton_open(3, 2, ctypes.c_void_p(address + 1)) is None
    assert library.dual_newton_open(0, 2, ctypes.c_void_p(address)) is None
    handle = ctypes.c_void_p(library.dual_newton_open(3, 2, ctypes.c_void_p(address)))
    length = ctypes.c_size_t()
    assert not library.dual_newton_array(handle, b"nonsense", ctypes.byref(length))


def test_results_outlive_the_solver() -> None:
    solver = dual_newton.DualNewton(200, 100)
    x = solver.x
    del solver
    assert x.sum() == 0.0


@pytest.mark.slow
def test_solved_row_holds_next_to_rows_of_other_sizes() -> None:
    """Coefficients are 1, 1e8 and 1e9. The residual is relative to the terms of the same row."""
    rng = np.random.default_rng(0)
    worst = 0.0
    for _ in range(3000):
        n, m_eq = int(rng.integers(2, 8)), int(rng.integers(1, 5))
        A = rng.normal(size=(m_eq, n)) * 10.0 ** rng.choice([0, 8, 9], (m_eq, n))
        lb, ub = np.zeros(n), 10.0 ** rng.choice([0, 3, 9], n)
        b = A @ (rng.uniform(lb, ub) * (rng.random(n) < 0.6))
        problem = BoxProblem(10.0 ** rng.choice([0, -6], n), rng.normal(size=n), A, b, lb, ub)
        answer = solve(problem)
        assert answer.status in ("solved", "not converged")
        if answer.status == "solved":
            worst = max(worst, row_error(problem, answer.x))
    assert worst < 2e-7
