from __future__ import annotations

import numpy as np
import pytest
import qpsolvers
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import null_space
from scipy.optimize import linprog, lsq_linear

from addin_sdfusion.robot import InputError, SimulationError, UnknownNameError
from controllers import ForceDistribution, ForceSolution
from controllers.qp import solver as qp

pytestmark = pytest.mark.native


def random_problem(seed: int, n: int, m: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a muscle Jacobian, force limits, and forces within the limits, some at a limit."""
    rng = np.random.default_rng(seed)
    L = rng.normal(size=(m, n)) * 0.1
    f = rng.uniform(10.0, 100.0, m)
    f[rng.random(m) < 0.5] = 10.0
    f[rng.random(m) < 0.2] = 100.0
    return L, f, rng.uniform(0.5, 2.0, m)


def is_optimal(L: np.ndarray, solution: ForceSolution, H: np.ndarray) -> bool:
    """Check the Karush-Kuhn-Tucker conditions: H f + L y is zero except at active limits."""
    f = solution.forces
    low = np.isclose(f, solution.f_min, atol=1e-7).astype(float)
    high = np.isclose(f, solution.f_max, atol=1e-7).astype(float)
    columns = np.hstack([L, -L, -np.diag(low), np.diag(high)])  # y = y+ - y-, and two multipliers
    multipliers = linprog(
        np.zeros(columns.shape[1]),
        A_ub=np.vstack([columns, -columns]),
        b_ub=np.concatenate([1e-5 - H * f, 1e-5 + H * f]),
        bounds=(0, None),
    )
    return bool(multipliers.status == 0)


@given(seed=st.integers(0, 10**6), n=st.integers(1, 6), extra=st.integers(0, 8))
def test_feasible_torque_has_minimum_cost(seed: int, n: int, extra: int) -> None:
    L, f, H = random_problem(seed, n, n + extra)
    distribution = ForceDistribution(np.full(n + extra, 10.0), np.full(n + extra, 100.0), weights=H)
    solution = distribution.solve(L, -L.T @ f)
    assert solution.status == "solved"
    assert solution.equality_residual < 1e-6 * (1 + np.abs(L.T @ f).max())
    assert solution.bound_violation == 0.0
    assert solution.forces @ (H * solution.forces) <= f @ (H * f) * (1 + 1e-6)
    assert is_optimal(L, solution, H)


@pytest.mark.parametrize("norm", [1.0, 4.0, np.inf])
def test_norms_of_muscles_and_motors(norm: float) -> None:
    """SciPy does not find forces nearer to the pretension; the motor torque may be negative."""
    rng = np.random.default_rng(3)
    L, low, high = rng.normal(size=(6, 2)), np.r_[np.full(4, 1.0), -30.0, -30.0], np.full(6, 60.0)
    wanted = np.r_[np.full(4, 20.0), 0.0, 0.0]
    distribution = ForceDistribution(low, high, norm=norm, pretension=wanted, motors=2)
    for f in rng.uniform(low, high, (5, 6)):
        solution = distribution.solve(L, -L.T @ f)
        assert solution.status == "solved"
        assert solution.equality_residual < 1e-6
        assert solution.bound_violation == 0.0
        least = np.linalg.norm(solution.forces - wanted, norm)
        directions = null_space(L.T) @ rng.normal(size=(4, 4000))
        for size in (1e-3, 1.0, 10.0):
            others = solution.forces[:, None] + size * directions
            others = np.clip(others, low[:, None], high[:, None])
            fitting = np.abs(L.T @ (others - f[:, None])).max(axis=0) < 1e-9
            norms = np.linalg.norm(others[:, fitting] - wanted[:, None], norm, axis=0)
            assert (norms >= least * (1 - 1e-9)).all()
    impossible = distribution.solve(L, np.array([1e4, 0.0]))
    squares = ForceDistribution(low, high, pretension=wanted, motors=2)
    assert impossible.status == "soft"
    np.testing.assert_array_equal(impossible.forces, squares.solve(L, np.array([1e4, 0.0])).forces)


@given(seed=st.integers(0, 10**6), n=st.integers(1, 6), extra=st.integers(0, 8))
def test_infeasible_torque_has_the_smallest_error(seed: int, n: int, extra: int) -> None:
    """Compare the slack with bounded least squares of SciPy, and feasibility with linprog."""
    m = n + extra
    L, _, _ = random_problem(seed, n, m)
    tau = np.random.default_rng(seed).normal(size=n) * 30.0
    low, high = np.full(m, 10.0), np.full(m, 100.0)
    solution = ForceDistribution(low, high).solve(L, tau)
    feasible = linprog(np.zeros(m), A_eq=-L.T, b_eq=tau, bounds=(10.0, 100.0)).status == 0
    best = lsq_linear(L.T, -tau, bounds=(low, high), tol=1e-14)
    error = np.linalg.norm(L.T @ best.x + tau)
    assert (solution.status == "solved") == feasible or error < 1e-4
    assert solution.bound_violation == 0.0
    np.testing.assert_allclose(solution.slack, tau + L.T @ solution.forces, atol=1e-12)
    assert np.linalg.norm(solution.slack) <= error * (1 + 1e-4) + 1e-5


def test_soft_solution_names_slack_and_active_limits() -> None:
    distribution = ForceDistribution(
        [10.0, 10.0],
        [50.0, 80.0],
        coordinate_names=["elbow"],
        muscle_names=["biceps", "triceps"],
    )
    solution = distribution.solve(np.array([[-0.1], [0.1]]), np.array([10.0]))
    assert solution.status == "soft"
    assert solution.slack[0] == pytest.approx(10.0 - (50.0 - 10.0) * 0.1)
    assert solution.at_max == ("biceps",)
    assert solution.at_min == ("triceps",)
    text = solution.describe()
    assert "elbow 6" in text
    assert "f_max: biceps" in text
    assert "f_min: triceps" in text


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_only_the_ratios_of_weights_matter(scale: float) -> None:
    for seed in range(20):
        L, f, H = random_problem(seed, 3, 7)
        low, high = np.full(7, 10.0), np.full(7, 100.0)
        plain = ForceDistribution(low, high, weights=H).solve(L, -L.T @ f)
        scaled = ForceDistribution(low, high, weights=scale * H).solve(L, -L.T @ f)
        assert scaled.status == "solved"
        np.testing.assert_allclose(scaled.forces, plain.forces, atol=1e-6)


def test_rejected_limits_change_nothing_and_solutions_are_copies() -> None:
    distribution = ForceDistribution([10.0, 10.0], [50.0, 50.0])
    with pytest.raises(InputError):
        distribution.set_bounds([20.0, 20.0], [10.0, 10.0])
    solution = distribution.solve([[-0.1], [0.1]], [0.5])  # type: ignore[arg-type]
    assert solution.status == "solved"
    solution.f_min[:] = -99.0
    assert distribution.f_min.tolist() == [10.0, 10.0]
    with pytest.raises(InputError, match="shape"):
        distribution.solve(np.ones((2, 2)), np.ones(1))


def test_unlimited_muscles_are_never_at_the_upper_limit() -> None:
    solution = ForceDistribution([0.0], [np.inf]).solve(np.array([[-0.1]]), np.array([1e4]))
    assert solution.status == "solved"
    assert solution.forces[0] == pytest.approx(1e5)
    assert solution.at_max == ()


@pytest.mark.parametrize("solver", [s for s in qp.available_solvers() if s != "scs"])
def test_all_back_ends_return_the_same_forces(solver: str) -> None:
    for seed in range(5):
        L, f, H = random_problem(seed, 3, 7)
        low, high = np.full(7, 10.0), np.full(7, 100.0)
        reference = ForceDistribution(low, high, weights=H).solve(L, -L.T @ f)
        other = ForceDistribution(low, high, weights=H, solver=solver).solve(L, -L.T @ f)
        assert other.status == "solved"
        np.testing.assert_allclose(other.forces, reference.forces, atol=1e-3)


@pytest.mark.parametrize(
    "lie",
    [
        lambda problem, solver: None,
        lambda problem, solver: np.full(problem.lb.size, 10.0),
        lambda problem, solver: np.full(problem.lb.size, 1e6),
    ],
)
def test_solutions_of_a_back_end_are_checked(monkeypatch: pytest.MonkeyPatch, lie: object) -> None:
    """A wrong solution of OSQP is rejected, and the default back end solves the problem."""
    honest = qp.solve
    monkeypatch.setattr(qp, "solve", lambda p, s: lie(p, s) if s == "osqp" else honest(p, s))
    L, f, H = random_problem(1, 3, 7)
    low, high = np.full(7, 10.0), np.full(7, 100.0)
    solution = ForceDistribution(low, high, weights=H, solver="osqp").solve(L, -L.T @ f)
    expected = ForceDistribution(low, high, weights=H).solve(L, -L.T @ f)
    assert np.array_equal(solution.forces, expected.forces)


def test_solutions_repeat_bit_for_bit_from_a_saved_state() -> None:
    """Feasible and infeasible ticks alternate."""
    rng = np.random.default_rng(0)
    ticks = [(rng.normal(size=(7, 3)), rng.normal(size=3) * 100.0) for _ in range(40)]
    low, high = np.full(7, 10.0), np.full(7, 100.0)
    first = ForceDistribution(low, high, coordinate_names=["a", "b", "c"])
    fresh = first.get_state()
    assert fresh.tolist() == [0.0] * 6
    for tick in ticks[:20]:
        first.solve(*tick)
    state = first.get_state()
    expected = [first.solve(*tick) for tick in ticks[20:]]
    assert {solution.status for solution in expected} == {"solved", "soft"}
    other = ForceDistribution(low, high)
    for distribution in (first, other):
        distribution.set_state(state)
        for solution, tick in zip(expected, ticks[20:], strict=True):
            assert distribution.solve(*tick).forces.tobytes() == solution.forces.tobytes()
    other.reset()
    assert other.get_state().tobytes() == fresh.tobytes()
    first.set_state(np.empty(0))
    assert first.get_state().tobytes() == fresh.tobytes()
    for wrong in (np.zeros(3), np.full(6, np.nan), np.zeros((2, 3))):
        with pytest.raises(InputError, match="finite numbers"):
            first.set_state(wrong)


def test_changed_limits_apply_to_the_next_solution() -> None:
    distribution = ForceDistribution([10.0, 10.0], [50.0, 50.0], coordinate_names=["elbow"])
    L, tau = np.array([[-0.1], [0.1]]), np.array([1.0])
    assert distribution.solve(L, tau).forces.tolist() == pytest.approx([20.0, 10.0])
    distribution.set_bounds([5.0, 5.0], [12.0, 50.0])
    solution = distribution.solve(L, tau)
    assert solution.forces.tolist() == pytest.approx([12.0, 5.0])
    assert solution.status == "soft"


def test_problem_is_built_without_solving_it() -> None:
    L, f, H = random_problem(2, 2, 5)
    tau = -L.T @ f
    problem = ForceDistribution(np.full(5, 10.0), np.full(5, 100.0), weights=H).build_problem(
        L, tau
    )
    assert isinstance(problem, qpsolvers.Problem)
    np.testing.assert_allclose(problem.P, np.diag(H / H.mean()))
    np.testing.assert_array_equal(problem.A, -L.T)
    np.testing.assert_array_equal(problem.b, tau)
    assert problem.lb.min() == 10.0
    assert problem.ub.max() == 100.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([20.0], [10.0]), "muscle 1.*f_min 20.0 is above f_max 10.0"),
        (([np.nan], [10.0]), "must be finite"),
        (([-1.0], [10.0]), "not negative"),
        (([0.0], [np.nan]), "above"),
        (([0.0, 0.0], [1.0]), "equal lengths"),
        (([], []), "equal lengths"),
    ],
)
def test_wrong_limits_raise_an_error(
    arguments: tuple[list[float], list[float]], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        ForceDistribution(*arguments)


def test_unknown_back_end_raises_an_error_with_suggestions() -> None:
    with pytest.raises(UnknownNameError, match=r"'dapq'; did you mean 'daqp'.*osqp"):
        ForceDistribution([0.0], [1.0], solver="dapq")


def test_torque_that_is_not_finite_raises_an_error() -> None:
    for solver in ("dual_newton", "daqp"):
        with pytest.raises(SimulationError, match="not finite"):
            ForceDistribution([0.0], [1.0], solver=solver).solve(
                np.array([[1.0]]), np.array([np.nan])
            )
    with pytest.raises(SimulationError, match="too large"):
        ForceDistribution([0.0], [1.0]).solve(np.array([[1e200]]), np.array([1.0]))


def test_mass_matrix_minimises_the_acceleration_error() -> None:
    """Compare infeasible problems with bounded least squares of M^-1 (tau + L'f)."""
    rng = np.random.default_rng(5)
    for _ in range(30):
        L, B = rng.normal(size=(5, 3)), rng.normal(size=(3, 3))
        M = B @ B.T + 0.05 * np.eye(3)
        tau = 1e3 * rng.normal(size=3)
        distribution = ForceDistribution(np.full(5, 10.0), np.full(5, 100.0))
        solution = distribution.solve(L, tau, M)
        assert solution.status == "soft"
        rows = np.linalg.solve(M, L.T)
        best = lsq_linear(rows, -np.linalg.solve(M, tau), bounds=(10.0, 100.0), method="bvls")
        error = np.linalg.norm(np.linalg.solve(M, solution.slack))
        assert error == pytest.approx(np.sqrt(2.0 * best.cost), rel=1e-6)
        np.testing.assert_allclose(solution.slack, tau + L.T @ solution.forces, atol=1e-9)
