"""The two-link arm with weak cables: at most poses some tasks ask for more than they can give."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.optimize import linprog, lsq_linear

from controllers import OperationalSpaceController, Posture, ReactiveQPController
from sim_dart import DartDynamics

KP, KD = 400.0, 40.0


def ticks(arm: DartDynamics, count: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Random states, at rest and fast, with tasks from met to far away."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        q = rng.uniform(-np.pi, np.pi, 2)
        qd = rng.normal(size=2) * rng.choice([0.0, 0.3, 3.0])
        yield q, qd, arm.task_position(q) + rng.normal(size=2) * rng.choice([0.0, 1e-3, 0.1, 1.0])


def terms(arm, q, qd, y_d):
    """a, B of qdd = a + B f, J, and what is desired of J qdd."""
    h = arm.coriolis(q, qd) + arm.gravity(q) + arm.damping * qd
    made = -np.linalg.solve(arm.mass_matrix(q), np.column_stack([h, arm.muscle_jacobian(q).T]))
    J = arm.task_jacobian(q)
    desired = KP * (y_d - arm.task_position(q)) - KD * J @ qd - arm.task_bias(q, qd)
    return made[:, 0], made[:, 1:], J, desired


def is_possible(arm, q, qd, y_d) -> bool:
    """Whether some forces meet the tasks, by a linear programme."""
    a, B, J, desired = terms(arm, q, qd, y_d)
    scale = np.abs(J @ B).max(axis=1)
    answer = linprog(
        np.zeros(4),
        A_eq=J @ B / scale[:, None],
        b_eq=(desired - J @ a) / scale,
        bounds=list(zip(arm.f_min, arm.f_max, strict=True)),
    )
    return answer.status == 0


def controller(kind, arm, **settings):
    posture = Posture(kd=10.0, kp=25.0, q0=[0.0, 0.0])
    return kind(arm, KP, KD, posture=posture, limit_bandwidth=None, **settings)


@pytest.mark.slow
@pytest.mark.parametrize("priorities", [None, [1, 2]])
def test_a_tick_is_soft_where_no_force_fits_and_nowhere_else(arm, priorities) -> None:
    law = controller(OperationalSpaceController, arm, priorities=priorities)
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


def test_tasks_give_way_no_more_than_they_must(arm) -> None:
    """But for what the posture bends them by: near singular poses it wants to be far off."""
    law = controller(OperationalSpaceController, arm)
    for q, qd, y_d in ticks(arm, 100):
        solution = law.solve(q, qd, y_d, np.zeros(2), np.zeros(2))
        a, B, J, desired = terms(arm, q, qd, y_d)
        least = lsq_linear(J @ B, desired - J @ a, (arm.f_min, arm.f_max), method="bvls")
        missing = np.linalg.norm(J @ (a + B @ least.x) - desired)
        bent = 0.01 * np.linalg.norm(solution.qdd)
        assert np.linalg.norm(solution.slack) <= missing + bent + 1e-3


def test_the_first_priority_gives_way_no_more_for_the_sake_of_the_second(arm) -> None:
    law = controller(OperationalSpaceController, arm, priorities=[1, 2])
    for q, qd, y_d in ticks(arm, 100):
        solution = law.solve(q, qd, y_d, np.zeros(2), np.zeros(2))
        a, B, J, desired = terms(arm, q, qd, y_d)
        first = (J @ B)[:1]
        least = lsq_linear(first, (desired - J @ a)[:1], (arm.f_min, arm.f_max), method="bvls")
        missing = np.abs(first @ least.x + J[0] @ a - desired[0]).item()
        bent = 0.01 * np.linalg.norm(solution.qdd)
        assert np.abs(solution.slack[0]) <= missing + bent + 1e-3


def test_a_task_as_cost_always_has_a_solution(arm) -> None:
    law = controller(ReactiveQPController, arm)
    for q, qd, y_d in ticks(arm, 200):
        solution = law.solve(q, qd, y_d, np.zeros(2), np.zeros(2))
        assert solution.status == "solved"
        assert solution.bound_violation == 0.0
