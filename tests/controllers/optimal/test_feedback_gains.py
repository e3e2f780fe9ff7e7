"""Feedback gains along a motion: discrete Riccati equation, and a dense least-squares problem."""

from __future__ import annotations

import numpy as np
import pytest

from controllers.optimal.feedback import Stage, gains_along, stationary_gain

H = 0.02
A = np.array([[1.0, H], [0.3 * H, 1.0]])  # an unstable pendulum, in two directions of force
B = np.array([[0.5 * H**2, -0.2 * H**2], [H, -0.4 * H]])
STAGE = Stage(A, B, np.diag([100.0, 1.0]), np.array([0.1, 0.02]))


def test_stationary_gain_satisfies_the_discrete_riccati_equation() -> None:
    found = stationary_gain(STAGE)
    assert found is not None
    K, P = found
    np.testing.assert_allclose((np.diag(STAGE.R) + B.T @ P @ B) @ K, B.T @ P @ A, rtol=1e-9)
    np.testing.assert_allclose(STAGE.Q + A.T @ P @ (A - B @ K), P, rtol=1e-9)
    assert abs(np.linalg.eigvals(A - B @ K)).max() < 1.0


def test_first_gain_of_a_long_motion_is_the_stationary_one() -> None:
    found = stationary_gain(STAGE)
    assert found is not None
    np.testing.assert_allclose(gains_along([STAGE] * 800, STAGE.Q)[0], found[0], rtol=1e-6)


def test_gains_minimise_the_cost_of_a_motion() -> None:
    """The controls of the feedback are the least-squares controls of all intervals at once."""
    rng = np.random.default_rng(0)
    stages = [
        Stage(A + 0.1 * rng.normal(size=(2, 2)), B * rng.uniform(1, 9), STAGE.Q * k, STAGE.R)
        for k in range(1, 7)
    ]
    end, x, N = np.eye(2), np.array([1.0, -2.0]), len(stages)
    gains = gains_along(stages, end)
    free, forced, rows, right = np.eye(2), np.zeros((2, 2 * N)), [], []
    for k, own in enumerate(stages):  # states as functions of x0 and all controls
        root = np.linalg.cholesky(own.Q).T
        rows.append(root @ forced)
        right.append(-root @ free @ x)
        free, forced = own.A @ free, own.A @ forced
        forced[:, 2 * k : 2 * k + 2] += own.B
    rows += [forced, np.kron(np.eye(N), np.diag(np.sqrt(STAGE.R)))]
    right += [-free @ x, np.zeros(2 * N)]
    best = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0].reshape(N, 2)
    for own, K, u in zip(stages, gains, best, strict=True):
        np.testing.assert_allclose(-K @ x, u, rtol=1e-8, atol=1e-10)
        x = own.A @ x + own.B @ u


def test_robot_that_no_control_stabilises_has_no_stationary_gain() -> None:
    assert stationary_gain(STAGE._replace(B=np.zeros((2, 2)))) is None
    assert np.isfinite(gains_along([STAGE._replace(B=np.zeros((2, 2)))], STAGE.Q)).all()


def test_gain_of_a_scalar_system_has_its_closed_form() -> None:
    """A = b = q = r = 1: the golden ratio."""
    one = np.ones((1, 1))
    found = stationary_gain(Stage(one, one, one, np.ones(1)))
    assert found is not None
    assert found[1][0, 0] == pytest.approx((1.0 + np.sqrt(5.0)) / 2.0, rel=1e-9)
