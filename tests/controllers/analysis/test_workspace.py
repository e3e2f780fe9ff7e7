"""Compare workspaces on grids with closed forms and linear programs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog, minimize

from addin_sdfusion.robot import InputError, UnknownNameError, read_robot
from controllers.analysis.workspace import (
    is_wrench_closed,
    is_wrench_feasible,
    joint_grid,
    workspace,
)
from controllers.analysis.workspace_metrics import (
    condition_number,
    tension_factor,
    unilateral_dexterity,
)
from controllers.analysis.wrench_set import capacity_margin, torque_margins
from sim_dart import DartDynamics

GRID = joint_grid([-1.2, -1.2], [1.2, 1.2], 9)


def _feasible(arm: DartDynamics, L: np.ndarray, tau: np.ndarray) -> bool:
    box = list(zip(arm.f_min, arm.f_max, strict=True))
    return bool(linprog(np.zeros(4), A_eq=-L.T, b_eq=tau, bounds=box).status == 0)


def test_wrench_closure_of_the_two_link_arm_matches_the_closed_form(arm: DartDynamics) -> None:
    """Only cables 2 and 4 act on the elbow. Their moment arms must have opposite signs."""
    closed = workspace(arm, GRID, conditions=["wrench_closure"]).conditions["wrench_closure"]
    for q, found in zip(GRID.reshape(-1, 2), closed.ravel(), strict=True):
        (a1, _), (a2, b2), (a3, _), (a4, b4) = arm.muscle_jacobian(q)
        elbow = np.sign(a2 * abs(b4) + a4 * abs(b2))
        antagonists = a1 * a3 < 0 or (a1 * elbow < 0 or a3 * elbow < 0)
        assert found == (b2 * b4 < 0 and antagonists)
    assert 0 < closed.sum() < closed.size


@pytest.mark.slow
def test_conditions_match_linear_programs(arm: DartDynamics) -> None:
    found = workspace(
        arm,
        GRID,
        conditions=["wrench_closure", "static", "wrench_feasible", "dynamic"],
        metrics=["capacity_margin"],
        loads=[2.0, 1.0],
        accelerations=15.0,
    )
    corners = [np.array(c) for c in ((1, 1), (1, -1), (-1, 1), (-1, -1))]
    expected = {"static": [], "wrench_feasible": [], "dynamic": []}
    for q in GRID.reshape(-1, 2):
        L, G, M = arm.muscle_jacobian(q), arm.gravity(q), arm.mass_matrix(q)
        expected["static"].append(_feasible(arm, L, G))
        loads = [G + c * [2.0, 1.0] for c in corners]
        expected["wrench_feasible"].append(all(_feasible(arm, L, tau) for tau in loads))
        moving = [M @ (15.0 * c) + G for c in corners]
        expected["dynamic"].append(all(_feasible(arm, L, tau) for tau in moving))
    for condition, holds in expected.items():
        assert np.array_equal(found.conditions[condition].ravel(), holds), condition
        assert 0 < found.share(condition) < 1
    inside = found.metrics["capacity_margin"] >= 0
    assert np.array_equal(inside, found.conditions["wrench_feasible"])
    assert found.q.shape == (9, 9, 2)


def test_left_arm_fulfils_all_conditions_in_the_middle_of_its_range(shared: Path) -> None:
    dynamics = DartDynamics(read_robot(shared / "robots/caspr/RoboyLeftArm", "DEFAULT"))
    grid = joint_grid([1.35, -0.1, -0.1, -1.4], [1.56, 0.1, 0.1, -1.0], 2)
    found = workspace(dynamics, grid, metrics=["capacity_margin", "tension_factor"])
    assert found.share("wrench_closure") == 1.0
    assert found.share("static") == 1.0
    assert (found.metrics["capacity_margin"] > 0).all()
    assert (found.metrics["tension_factor"] > 0).all()


def test_robots_with_many_muscles_use_linear_programs(shared: Path) -> None:
    """26 coordinates have too many facets, so that the corners of the set are checked instead."""
    dynamics = DartDynamics(read_robot(shared / "robots/caspr/RoboyUpperBody", "DEFAULT"))
    L = dynamics.muscle_jacobian(np.zeros(26))
    assert not is_wrench_closed(L)
    tau = -L.T @ np.full(38, 50.0)
    narrow = L.T @ np.eye(38)[:, :3]
    assert is_wrench_feasible(L, tau, 0.0, 100.0, half_widths=20.0 * narrow)
    assert not is_wrench_feasible(L, tau, 49.0, 51.0, half_widths=200.0 * narrow)
    with pytest.raises(InputError, match="26 corners"):
        is_wrench_feasible(L, tau, 0.0, 100.0, half_widths=np.eye(26))


def test_condition_number_is_the_ratio_of_singular_values() -> None:
    L = np.diag([3.0, 4.0, 6.0])[:, :3]
    assert condition_number(L) == pytest.approx(0.5)
    assert condition_number(0.0 * L) == 0.0
    assert condition_number(L[:2]) == 0.0


def test_tension_factor_is_the_largest_ratio() -> None:
    """Compare it with 1 for a star, with the null vector for m = n + 1, and with SLSQP."""
    angles = np.deg2rad([0, 120, 240])
    star = np.column_stack([np.cos(angles), np.sin(angles)])
    assert tension_factor(star) == pytest.approx(1.0)
    assert tension_factor(star * [[2.0], [1.0], [1.0]]) == pytest.approx(0.5)
    assert tension_factor(star[[0, 1, 1]]) == 0.0
    L = np.vstack([star, [[0.5, 0.2], [-1.0, 0.4]]])
    best = minimize(
        lambda f: -f.min(),
        np.full(5, 0.3),
        bounds=[(0.0, 1.0)] * 5,
        constraints={"type": "eq", "fun": lambda f: L.T @ f},
        options={"ftol": 1e-12, "maxiter": 500},
    )
    assert tension_factor(L) >= -best.fun - 1e-6
    assert tension_factor(L) < 1.0


def test_unilateral_dexterity_matches_the_formula_of_caspr() -> None:
    """A star of n + 1 equal muscles has the maximum. Without wrench closure the result is 0."""
    angles = np.deg2rad([0, 120, 240])
    star = np.column_stack([np.cos(angles), np.sin(angles)])
    h = 1 / np.sqrt(3)
    assert unilateral_dexterity(star) == pytest.approx(2.0 * h / np.sqrt(h**2 + 1))
    assert unilateral_dexterity(star[:2]) == 0.0
    assert unilateral_dexterity(np.abs(star)) == 0.0
    useless = np.vstack([star, [[1e-3, 0.0]]])  # better without the last muscle
    assert unilateral_dexterity(useless) == pytest.approx(float(unilateral_dexterity(star)))
    stack = np.stack([star, np.abs(star)])
    assert unilateral_dexterity(stack).shape == (2,)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"conditions": ["statics"]}, "did you mean 'static'"),
        ({"metrics": ["dexterity"]}, "no metric 'dexterity'"),
        ({"conditions": ["dynamic"]}, "requires accelerations"),
        ({"conditions": ["wrench_feasible"]}, "requires loads"),
        ({"loads": [1.0, 2.0, 3.0]}, "loads must be a number or 2"),
        ({"loads": -1.0}, "not negative"),
        ({"q": np.zeros((3, 3))}, r"q must be finite with shape \(..., 2\)"),
        ({"q": [np.nan, 0.0]}, "q must be finite"),
    ],
)
def test_wrong_input_raises_an_error(
    arm: DartDynamics, change: dict[str, object], message: str
) -> None:
    arguments: dict[str, object] = {"q": GRID} | change
    with pytest.raises(InputError, match=message):
        workspace(arm, **arguments)  # type: ignore[arg-type]


def test_grids_require_limits_and_points(arm: DartDynamics) -> None:
    assert joint_grid([0.0, 1.0], [1.0, 2.0], [2, 3]).shape == (2, 3, 2)
    for lower, upper, points in (
        ([-np.inf, 0.0], [1.0, 1.0], 3),
        ([0.0], [1.0, 1.0], 3),
        ([0.0, 0.0], [1.0, 1.0], [3]),
        ([0.0, 0.0], [1.0, 1.0], 0),
    ):
        with pytest.raises(InputError):
            joint_grid(lower, upper, points)
    with pytest.raises(UnknownNameError, match="no condition 'static'"):
        workspace(arm, GRID[:1, :1], conditions=["wrench_closure"]).share("static")


@pytest.mark.parametrize("m", range(6))
@pytest.mark.parametrize("n", range(5))
def test_any_number_of_muscles_and_coordinates_is_supported(m: int, n: int) -> None:
    """Wrench closure requires n + 1 muscles; without coordinates it always holds."""
    L = np.vstack([np.eye(n), -np.ones((6, n))])[:m]
    for stack in (L, np.array([L, L])):
        assert (
            is_wrench_closed(stack).tolist() == np.full(stack.shape[:-2], m > n or not n).tolist()
        )
    if m and n:
        margin = capacity_margin(L, np.zeros(n), np.zeros(m), np.ones(m))
        assert np.isnan(margin) == (m < n)
        down, up = torque_margins(L, np.zeros(n), np.zeros(m), np.ones(m))
        assert np.isnan([down, up]).all() == (m < n)
