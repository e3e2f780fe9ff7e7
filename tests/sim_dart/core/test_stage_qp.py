"""Quadratic programs over stages: against a dense solver, and against Riccati's equation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are
from support.controllers.stage_program import StageProgram, random_program


def test_solution_equals_dense_solver() -> None:
    active = 0
    for seed in range(20):
        program = random_program(seed)
        assert program.solve() == 0
        v = program["v"]
        assert v == pytest.approx(program.dense_solution(), abs=1e-8)
        hard = program["penalty"] == 0.0
        bounds = np.minimum(abs(v - program["low"]), abs(v - program["high"]))
        active += int((bounds[hard] < 1e-7).sum())
    assert active > 100


def test_feedback_without_bounds_is_lqr() -> None:
    A, B = np.array([[1.0, 0.1], [-0.3, 0.95]]), np.array([[0.0], [0.1]])
    Q, R, start = np.diag([4.0, 0.5]), np.array([[0.2]]), np.array([1.0, -0.5])
    P = solve_discrete_are(A, B, Q, R)
    program, N = StageProgram(7, 2, 1), 7
    stage = np.block([[R, np.zeros((1, 2))], [np.zeros((2, 1)), Q]])
    program["H"][:] = np.concatenate([np.tile(stage.ravel(), N), P.ravel()])
    program["C"][:], program["start"][:] = np.tile(np.hstack([B, A]).ravel(), N), start
    assert program.solve() == 0
    gain = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)
    assert program["v"][:1] == pytest.approx(-gain @ start, rel=1e-12)
    assert program["v"][-2:] == pytest.approx(
        np.linalg.matrix_power(A - B @ gain, N) @ start, rel=1e-11
    )


def test_double_integrator_with_bound_equals_explicit_law() -> None:
    """One step ahead: u = clip of the unconstrained minimiser, for all states."""
    A, B = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[0.005], [0.1]])
    for start in np.random.default_rng(0).normal(size=(10, 2)):
        program = StageProgram(1, 2, 1)
        program["H"][:] = [0.01, 0, 0, 0, 0, 0, 0, 0, 0, 1.0, 0.0, 0.0, 1.0]
        program["C"][:], program["start"][:] = np.hstack([B, A]).ravel(), start
        program["low"][0], program["high"][0] = -2.0, 2.0
        program["tolerance"][:] = 1e-14, 1e-12
        assert program.solve() == 0
        free = -(B.T @ A @ start) / (0.01 + B.T @ B)
        assert program["v"][0] == pytest.approx(np.clip(free.item(), -2.0, 2.0), abs=1e-9)


def test_iterations_are_limited() -> None:
    program = random_program(3)
    assert program.solve(iterations=2) == 1


def test_cost_that_is_not_convex_fails() -> None:
    program = StageProgram(2, 1, 1)
    program["H"][:] = -1.0
    program["C"][:] = 1.0
    assert program.solve() == 2
