"""Strength that a motion needs after failures: closed forms, and another linear program."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog
from support.robots.random_robots import random_robot

from controllers.analysis.failures import required_strength
from controllers.analysis.inverse_dynamics import Motion, MotionTerms, motion_terms
from sim_dart import DartDynamics


def _lever(tau: list[float], motors: int = 0) -> MotionTerms:
    """Return a joint with a flexor and an extensor at 0.05 m, and motors."""
    points = len(tau)
    zero = np.zeros((points, 1))
    L = np.tile([[-0.05], [0.05], *[[-1.0]] * motors], (points, 1, 1))
    return MotionTerms(
        Motion(np.arange(points, dtype=float), zero, zero, zero),
        np.array(tau)[:, None],
        L,
        np.array([1.0, 1.0, *[-2.0] * motors]),
        np.array([100.0, 50.0, *[2.0] * motors]),
        ("flexor", "extensor", "motor")[: 2 + motors],
        ("joint",),
        motors,
    )


def test_lever_needs_its_torque_and_the_minimum_force_of_the_antagonist() -> None:
    terms = _lever([2.0, -1.0, 0.0])
    # 0.05 (f_1 - f_2) = tau with the other muscle at f_min = 1 N
    intact = [41.0 / 100.0, 21.0 / 50.0, 1.0 / 50.0]
    assert required_strength(terms) == pytest.approx(intact, abs=1e-9)
    alone = required_strength(terms, [1])
    assert alone[0] == pytest.approx(0.4, abs=1e-9)
    assert np.isinf(alone[1])  # a cable cannot push
    assert np.isinf(alone[2])  # the flexor cannot be slack
    assert np.isinf(required_strength(terms, [0, 1])[:2]).all()


def test_motor_works_in_both_directions() -> None:
    terms = _lever([1.0, -1.0], motors=1)
    assert required_strength(terms, [0, 1]) == pytest.approx([0.5, 0.5], abs=1e-9)
    # s 100 0.05 - 0.05 + 2 s = 1 N m
    assert required_strength(terms)[0] == pytest.approx(1.05 / 7.0, abs=1e-9)
    assert required_strength(terms, [2])[0] == pytest.approx(0.21, abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_each_point_equals_its_own_linear_program(seed: int) -> None:
    robot, rng = random_robot(seed), np.random.default_rng(seed)
    points, n = 5, len(robot.coordinates)
    states = [rng.uniform(-0.5, 0.5, (points, n)) for _ in range(3)]
    terms = motion_terms(DartDynamics(robot), Motion(np.arange(points, dtype=float), *states))
    found = required_strength(terms, [0])
    for k, strength in enumerate(found):
        f_max = np.where(np.arange(len(terms.f_max)) == 0, 0.0, terms.f_max)
        f_min = np.where(np.arange(len(terms.f_max)) == 0, 0.0, terms.f_min)
        m = len(f_max)
        single = linprog(
            np.append(np.zeros(m), 1.0),
            A_ub=np.c_[np.eye(m), -f_max],
            b_ub=np.zeros(m),
            A_eq=np.c_[-terms.L[k].T, np.zeros(n)],
            b_eq=terms.tau[k],
            bounds=[*[(f, None) for f in f_min], (0.0, None)],
        )
        assert np.isfinite(strength) == (single.status == 0)
        if np.isfinite(strength):
            assert strength == pytest.approx(single.x[-1], rel=1e-6)
