"""Tests of infeasible tasks with the two-link arm, whose cables are too weak at most poses."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.optimize import linprog, lsq_linear

from controllers import OperationalSpaceController, Posture
from controllers.laws.operational_space import TASK_WEIGHT
from sim_dart import DartDynamics

KP, KD = 400.0, 40.0


def ticks(arm: DartDynamics, count: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield random states, at rest and fast, with small and large task errors."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        q = rng.uniform(-np.pi, np.pi, 2)
        qd = rng.normal(size=2) * rng.choice([0.0, 0.3, 3.0])
        yield q, qd, arm.task_position(q) + rng.normal(size=2) * rng.choice([0.0, 1e-3, 0.1, 1.0])


def terms(arm, q, qd, y_d):
    """Return a and B of qdd = a + B f, J, and the desired J qdd."""
    h = arm.coriolis(q, qd) + arm.gravity(q) + arm.damping * qd
    made = -np.linalg.solve(arm.mass_matrix(q), np.column_stack([h, arm.muscle_jacobian(q).T]))
    J = arm.task_jacobian(q)
    desired = KP * (y_d - arm.task_position(q)) - KD * J @ qd - arm.task_bias(q, qd)
    return made[:, 0], made[:, 1:], J, desired


def is_possible(arm, q, qd, y_d) -> bool:
    """Return whether the tasks are feasible, by a linear program."""
    a, B, J, desired = terms(arm, q, qd, y_d)
    scale = np.abs(J @ B).max(axis=1)
    answer = linprog(
        np.zeros(4),
        A_eq=J @ B / scale[:, None],
        b_eq=(desired - J @ a) / scale,
        bounds=list(zip(arm.f_min, arm.f_max, strict=True)),
    )
    return answer.status == 0


def controller(arm, **settings):
    posture = Posture(kd=10.0, kp=25.0, q0=[0.0, 0.0])
    return OperationalSpaceController(
        arm, KP, KD, posture=posture, limit_bandwidth=None, **settings
    )


@pytest.mark.slow
@pytest.mark.parametrize("priorities", [None, [1, 2]])
def test_tick_is_soft_if_and_only_if_it_is_infeasible(arm, priorities) -> None:
    law = controller(arm, priorities=priorities)
    soft = 0
    for q, qd, y_d in ticks(arm, 200):
        solution = law.solve(q, qd, y_d, np.zeros(2), np.zeros(2))
        assert np.isfinite(solution.forces).all()
        assert solution.bound_violation == 0.0
        assert (solution.status == "solved") == is_possible(arm, q, qd, y_d)
        a, B, _, _ = terms(arm, q, qd, y_d)
        reached = a + B @ solution.forces
        np.testing.assert_allclose(solution.qdd, reached, rtol=1e-6, atol=1e-4)
        soft += solution.status == "soft"
    assert 50 < soft < 190


def test_violation_of_tasks_is_minimal(arm) -> None:
    """The tolerance includes the effect of the posture, which is large near singular poses."""
    law = controller(arm)
    for q, qd, y_d in ticks(arm, 100):
        solution = law.solve(q, qd, y_d, np.zeros(2), np.zeros(2))
        a, B, J, desired = terms(arm, q, qd, y_d)
        least = lsq_linear(J @ B, desired - J @ a, (arm.f_min, arm.f_max), method="bvls")
        missing = np.linalg.norm(J @ (a + B @ least.x) - desired)
        bent = 0.01 * np.linalg.norm(solution.qdd)
        assert np.linalg.norm(solution.slack) <= missing + bent + 1e-3


def test_second_priority_does_not_affect_the_first(arm) -> None:
    law = controller(arm, priorities=[1, 2])
    for q, qd, y_d in ticks(arm, 100):
        solution = law.solve(q, qd, y_d, np.zeros(2), np.zeros(2))
        a, B, J, desired = terms(arm, q, qd, y_d)
        first = (J @ B)[:1]
        least = lsq_linear(first, (desired - J @ a)[:1], (arm.f_min, arm.f_max), method="bvls")
        missing = np.abs(first @ least.x + J[0] @ a - desired[0]).item()
        bent = 0.01 * np.linalg.norm(solution.qdd)
        assert np.abs(solution.slack[0]) <= missing + bent + 1e-3


def test_task_in_the_cost_is_always_feasible(arm) -> None:
    law = controller(arm, task_weights=TASK_WEIGHT)
    for q, qd, y_d in ticks(arm, 200):
        solution = law.solve(q, qd, y_d, np.zeros(2), np.zeros(2))
        assert solution.status == "solved"
        assert solution.bound_violation == 0.0
