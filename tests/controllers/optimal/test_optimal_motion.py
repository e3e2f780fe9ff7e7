"""Optimal motions of a mass with closed-form solutions."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from controllers.optimal.costs import Costs
from controllers.optimal.node_costs import squares
from controllers.optimal.problem import (
    NO_PARAMETERS,
    Iterate,
    NodeConstraint,
    OptimalProblem,
    Parameters,
)
from controllers.optimal.sqp import Optimiser, Progress, Solution

Floats = NDArray[np.float64]
MASS, FORCE = 2.0, 50.0


class Ends(NamedTuple):
    ends: Floats
    A: Floats
    B: Floats
    c: Floats
    D: Floats


class Mass:
    """A mass on a line, exact for constant forces. Parameters: push, a constant force."""

    def run(
        self,
        x: Floats,
        u: Floats,
        h: Floats,
        derivatives: bool = True,
        parameters: Floats = NO_PARAMETERS,
        nodes: object = None,
    ) -> Ends:
        a = (u[:, 0] + parameters.sum()) / MASS
        ends = np.stack([x[:, 0] + h * x[:, 1] + 0.5 * h * h * a, x[:, 1] + h * a], axis=1)
        A = np.tile(np.eye(2), (len(h), 1, 1))
        A[:, 0, 1] = h
        B = np.stack([0.5 * h * h / MASS, h / MASS], axis=1)[:, :, None]
        c = np.stack([x[:, 1] + h * a, a], axis=1)
        return Ends(ends, A, B, c, np.repeat(B, len(parameters), axis=2))


class Oscillator:
    """A mass on a line with a spring, exact for constant forces."""

    def __init__(self, stiffness: float) -> None:
        self._k, self._w = stiffness, np.sqrt(stiffness / MASS)

    def run(
        self,
        x: Floats,
        u: Floats,
        h: Floats,
        derivatives: bool = True,
        parameters: Floats = NO_PARAMETERS,
        nodes: object = None,
    ) -> Ends:
        w, c, s = self._w, np.cos(self._w * h), np.sin(self._w * h)
        A = np.moveaxis(np.array([[c, s / w], [-w * s, c]]), 2, 0)
        B = np.stack([(1.0 - c) / self._k, w * s / self._k], axis=1)[:, :, None]
        ends = np.einsum("kij,kj->ki", A, x) + B[:, :, 0] * u
        rates = np.stack([ends[:, 1], (u[:, 0] - self._k * ends[:, 0]) / MASS], axis=1)
        return Ends(ends, A, B, rates, np.empty((len(h), 2, len(parameters))))


def costs(force: float = 0.0, rate: float = 0.0, speed: float = 0.0, time: float = 0.0) -> Costs:
    zero = np.zeros(1), np.zeros(2)
    return Costs(np.array([force]), np.array([0.0, speed]), np.array([rate]), time, *zero)


def problem(
    cost: Costs, duration: tuple[float, float], N: int = 50, distance: float = 1.0
) -> OptimalProblem:
    low = np.full((N + 1, 2), -100.0)
    high = -low
    low[0] = high[0] = 0.0
    low[-1] = high[-1] = [distance, 0.0]
    force = np.full((N, 1), FORCE)
    names = ("x", "v"), ("f",)
    return OptimalProblem(Mass(), low, high, -force, force, duration, cost, (), *names)


def solve(own: OptimalProblem, **options: float) -> Solution:
    N = own.intervals
    start = Iterate(np.zeros((N + 1, 2)), np.zeros((N, 1)), float(np.sqrt(np.prod(own.duration))))
    found = Optimiser(own, **options).solve(start)  # type: ignore[arg-type]
    assert found is not None
    return found


def test_least_time_is_that_of_full_acceleration_and_braking() -> None:
    found = solve(problem(costs(time=1.0), (0.05, 5.0)))
    assert found.status == "optimal"
    assert found.iterate.duration == pytest.approx(2.0 * np.sqrt(MASS / FORCE), abs=1e-6)
    np.testing.assert_allclose(abs(found.iterate.u), FORCE, atol=1e-2)
    assert len(found.history) <= 12


def test_least_effort_is_that_of_the_normal_equations() -> None:
    """The smallest forces that satisfy both end conditions, in one step."""
    found, T, N = solve(problem(costs(force=3.0), (0.8, 0.8))), 0.8, 50
    h, k = T / N, np.arange(N)
    rows = np.stack([h * h * (N - k - 0.5), np.full(N, h)]) / MASS
    forces = np.linalg.lstsq(rows, np.array([1.0, 0.0]), rcond=None)[0]
    assert abs(forces).max() < FORCE
    np.testing.assert_allclose(found.iterate.u[:, 0], forces, rtol=1e-6, atol=1e-6)
    assert found.cost == pytest.approx(3.0 * h * forces @ forces, rel=1e-8)


@pytest.mark.parametrize(("distance", "speed"), [(3.0, 100.0), (0.2, 100.0), (3.0, 5.0)])
def test_least_time_with_a_limit_of_the_speed(distance: float, speed: float) -> None:
    """2 sqrt(m d / F), or d / v + m v / F with a speed limit v."""
    own = problem(costs(time=1.0), (0.01, 20.0), distance=distance)
    own.x_low[1:-1, 1], own.x_high[1:-1, 1] = -speed, speed
    found = solve(own)
    top = min(speed, np.sqrt(FORCE * distance / MASS))
    expected = distance / top + MASS * top / FORCE
    assert found.status == "optimal"
    assert found.iterate.duration == pytest.approx(expected, rel=1e-3)  # a node ends acceleration
    assert found.iterate.duration >= expected - 1e-9


def test_least_effort_with_a_limit_of_the_position_is_that_of_bryson() -> None:
    """Bryson and Ho (1975), section 3.11: 4 / (9 l) for the limit l <= 1/6 of the position."""
    own, N = problem(costs(force=0.5 / MASS**2), (1.0, 1.0), N=100, distance=0.0), 100
    own.x_low[0] = own.x_high[0] = [0.0, 1.0]
    own.x_low[N] = own.x_high[N] = [0.0, -1.0]
    own.x_high[1:N, 0] = 1.0 / 9.0
    found = solve(own)
    assert found.status == "optimal"
    assert found.cost == pytest.approx(4.0, rel=2e-3)


def test_least_effort_of_a_mass_on_a_spring_is_that_of_its_gramian() -> None:
    """The least integral of f^2 is b' W^-1 b, with the Gramian W of the sampled oscillator."""
    stiffness, T, N = 30.0, 0.8, 50
    own = problem(costs(force=1.0), (T, T), N=N)
    found = solve(replace(own, dynamics=Oscillator(stiffness)))
    w, h = np.sqrt(stiffness / MASS), T / N
    left = T - h * np.arange(1, N + 1)
    columns = [
        (np.cos(w * left) - np.cos(w * (left + h))) / stiffness,
        (np.sin(w * (left + h)) - np.sin(w * left)) * w / stiffness,
    ]
    gramian = np.array(columns) @ np.array(columns).T / h
    goal = np.array([1.0, 0.0])
    assert abs(found.iterate.u).max() < FORCE
    assert found.cost == pytest.approx(goal @ np.linalg.solve(gramian, goal), rel=1e-7)


def test_free_duration_balances_effort_and_time() -> None:
    """Effort 12 w m² d² / (T³ (1 - 1/N²)) with constant forces in N intervals."""
    found = solve(problem(costs(force=1.0, time=144.0), (0.1, 3.0)), tolerance=1e-12)
    assert found.status == "optimal"
    expected = (36.0 * MASS**2 / 144.0 / (1.0 - 1.0 / 50**2)) ** 0.25
    assert found.iterate.duration == pytest.approx(expected, rel=1e-6)


def test_last_iterations_satisfy_the_constraints_of_a_motion_that_is_not_optimal() -> None:
    own = problem(costs(force=1.0, time=144.0), (0.1, 3.0))
    found = solve(own, max_iterations=4)
    assert found.status == "not converged"
    assert found.is_feasible
    assert solve(own).cost < found.cost


def test_free_push_shares_the_effort_with_the_forces() -> None:
    """Least norm of the forces and of the push, weighted by its cost, that reach the end."""
    own, T, N, w = problem(costs(force=3.0), (0.8, 0.8)), 0.8, 50, 0.01
    h, k = T / N, np.arange(N)
    own = replace(own, parameters=Parameters(*np.array([[-50.0], [50.0], [1.0], [w]]), ("push",)))
    found = solve(own)
    rows = np.stack([h * h * (N - k - 0.5), np.full(N, h)]) / MASS
    weights = np.sqrt(np.array([*np.full(N, 3.0 * h), w]))
    pushed = np.column_stack([rows, rows.sum(axis=1)]) / weights
    goal = np.array([1.0, 0.0]) - rows.sum(axis=1)
    least = np.linalg.lstsq(pushed, goal, rcond=None)[0] / weights
    assert abs(least).max() < FORCE
    np.testing.assert_allclose(found.iterate.u[:, 0], least[:-1], rtol=1e-6, atol=1e-6)
    assert found.iterate.parameters[0] == pytest.approx(1.0 + least[-1], rel=1e-6)


def test_unreachable_goal_is_infeasible_and_the_force_is_at_its_limit() -> None:
    found = solve(problem(costs(force=1.0), (0.3, 0.3)))
    assert found.status == "infeasible"
    assert not found.is_feasible
    assert found.iterate.x[-1, 0] < 1.0


def test_node_constraint_keeps_the_mass_out_of_a_range() -> None:
    own = problem(costs(force=1.0), (1.0, 1.0))

    def speed(x: Floats) -> tuple[Floats, Floats]:
        return x[:, 1:], np.tile([[[0.0, 1.0]]], (len(x), 1, 1))

    limit = NodeConstraint("speed", ("v",), np.arange(51), speed, np.array([-9.0]), np.array([1.2]))
    found = solve(replace(own, constraints=(limit,)))
    assert found.status == "optimal"
    assert found.iterate.x[:, 1].max() == pytest.approx(1.2, abs=1e-6)


def test_gradient_and_hessian_of_the_costs_match_differences() -> None:
    rng = np.random.default_rng(1)
    weights = (rng.uniform(0.5, 2.0, k) for k in (2, 3, 2))
    G, nodes = rng.normal(size=(2, 3)), np.array([2, 5])

    def linear(x: Floats) -> tuple[Floats, Floats]:
        return x @ G.T, np.tile(G, (len(x), 1, 1))

    own = Costs(*weights, 0.7, np.zeros(2), np.ones(3), rng.uniform(0.5, 2.0, 3))
    own = replace(own, nodes=[squares(nodes, k, linear, G[:, 0] ** 2, G[0, :2]) for k in (0, 1)])
    x, u, T, e = rng.normal(size=(6, 3)), rng.normal(size=(5, 2)), 0.8, 1e-6
    terms = own.terms(x, u, T)
    dx, du, dt = rng.normal(size=x.shape), rng.normal(size=u.shape), 0.3

    def along(s: float) -> float:
        return own.value(x + s * dx, u + s * du, T + s * dt)

    slope = (terms.gx * dx).sum() + (terms.gu * du).sum() + terms.gt * dt
    assert slope == pytest.approx((along(e) - along(-e)) / (2.0 * e), rel=1e-8)
    coupling = 2.0 * ((terms.uv * du[:-1] * du[1:]).sum() + (terms.xv * dx[:-1] * dx[1:]).sum())
    coupling += np.einsum("ki,kij,kj", dx, terms.dense, dx)
    curvature = (terms.xx * dx**2).sum() + (terms.uu * du**2).sum() + coupling
    e = 1e-3
    fixed = [own.value(x + s * dx, u + s * du, T) for s in (e, 0.0, -e)]
    second = (fixed[0] - 2.0 * fixed[1] + fixed[2]) / e**2
    assert curvature == pytest.approx(second, rel=1e-6)


def test_interruption_returns_the_motion_so_far() -> None:
    """After the few iterations that satisfy the constraints, since the motion nearly does."""
    own = problem(costs(time=1.0), (0.05, 5.0))

    def interrupt(progress: Progress) -> None:
        if progress.iteration == 3:
            raise KeyboardInterrupt

    start = Iterate(np.zeros((51, 2)), np.zeros((50, 1)), 1.0)
    found = Optimiser(own).solve(start, interrupt)
    assert found is not None
    assert found.status == "interrupted"
    assert 1e-7 < found.history[3].violation < 0.1
    assert found.is_feasible
    assert len(found.history) <= 8
