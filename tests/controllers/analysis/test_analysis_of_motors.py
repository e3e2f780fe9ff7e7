"""Compare the analysis of robots with motors at joints with closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.arms import TwoLinkArm

from addin_sdfusion.robot import InputError
from controllers import ForceDistribution
from controllers.analysis.inverse_dynamics import Motion, motion_terms, size_muscles
from controllers.analysis.linearise import linearise_robot
from controllers.analysis.workspace import workspace
from controllers.force_distribution.gravity_compensation import gravity_compensation
from controllers.force_distribution.methods import METHODS
from controllers.force_distribution.motor_columns import merge_motors, split_motors

Q = np.array([[0.3, -0.4], [1.0, 0.5], [-0.7, 1.1]])


INCOMPLETE = ("closed_form", "puncture")
"""Methods that may fail for feasible torques with forces at their limits."""


class HybridArm(TwoLinkArm):
    """Arm with two muscles at the shoulder, two biarticular muscles, and a motor at the elbow."""

    motor_names = ("elbow",)
    f_min = np.array([5.0, 5.0, 5.0, 5.0, -20.0])
    f_max = np.array([5000.0, 5000.0, 5000.0, 5000.0, 30.0])

    def actuator_jacobian(self, q):
        return np.vstack([self.muscle_jacobian(q), [0.0, -1.0]])


class MotorArm(HybridArm):
    """Arm with motors and without muscles."""

    muscle_names = ()
    motor_names = ("shoulder", "elbow")
    f_min, f_max = np.array([-60.0, -20.0]), np.array([50.0, 30.0])

    def muscle_jacobian(self, q):
        return np.empty((0, 2))

    def actuator_jacobian(self, q):
        return -np.eye(2)


@pytest.fixture
def motion() -> Motion:
    return Motion(np.arange(3.0), Q, np.zeros((3, 2)), np.ones((3, 2)))


def test_motors_without_muscles_produce_the_required_torque(motion: Motion) -> None:
    arm = MotorArm()
    terms = motion_terms(arm, motion)
    found = terms.distribute()
    np.testing.assert_allclose(found.forces, terms.tau, atol=1e-9)
    np.testing.assert_allclose(gravity_compensation(arm, Q[0]), arm.gravity(Q[0]), atol=1e-9)
    down, up = found.torque_margins
    np.testing.assert_allclose(down, terms.tau - arm.f_min, rtol=1e-9)
    np.testing.assert_allclose(up, arm.f_max - terms.tau, rtol=1e-9)


def test_required_effort_of_motors_is_the_largest_absolute_torque() -> None:
    arm = MotorArm()
    upside_down = np.array([[np.pi, 0.0]])
    terms = motion_terms(arm, Motion([0.0], upside_down, np.zeros((1, 2)), np.zeros((1, 2))))
    assert (terms.tau < 0).all()
    np.testing.assert_allclose(size_muscles(terms).needed, 1.2 * np.abs(terms.tau[0]), rtol=1e-9)


ALL = sorted(name for name in METHODS if name not in INCOMPLETE and "polygon" not in name)


@pytest.mark.parametrize("method", ALL)
def test_every_method_uses_positive_and_negative_motor_torques(method: str, motion: Motion) -> None:
    arm = HybridArm()
    terms = motion_terms(arm, motion).with_bounds(None, [500.0, 500.0, 500.0, 500.0, 30.0])
    found = terms.distribute(method)
    assert found.solved.all()
    L = np.array([arm.actuator_jacobian(q) for q in Q])
    torque = -np.einsum("tan,ta->tn", L, found.forces)
    np.testing.assert_allclose(torque, terms.tau, atol=1e-6)
    assert (found.forces >= arm.f_min - 1e-6).all()


def test_minimum_sum_includes_the_absolute_motor_torque() -> None:
    """With one motor and tau < 0 the minimum sum is |tau|, not tau_min."""
    terms = motion_terms(MotorArm(), Motion([0.0], [[np.pi, 0.0]], [[0.0, 0.0]], [[0.0, 0.0]]))
    np.testing.assert_allclose(terms.distribute("linear_programme").forces, terms.tau, rtol=1e-9)


def test_least_squares_forces_equal_the_forces_of_the_controller(motion: Motion) -> None:
    arm = HybridArm()
    terms = motion_terms(arm, motion)
    distribution = ForceDistribution(arm.f_min, arm.f_max, motors=1)
    for L, tau, forces in zip(terms.L, terms.tau, terms.distribute().forces, strict=True):
        np.testing.assert_allclose(distribution.solve(L, tau).forces, forces, atol=1e-7)


def test_linear_robot_includes_motors() -> None:
    arm = HybridArm()
    linear = linearise_robot(arm, Q[0], np.zeros(2), gravity_compensation(arm, Q[0]))
    np.testing.assert_allclose(
        linear.B[2:, 4], np.linalg.solve(arm.mass_matrix(Q[0]), [0.0, 1.0]), rtol=1e-12
    )


def test_available_torques_of_motors_are_a_box() -> None:
    arm = MotorArm()
    found = workspace(arm, Q, metrics=["capacity_margin"])
    G = np.array([arm.gravity(q) for q in Q])
    margin = np.minimum(G - arm.f_min, arm.f_max - G).min(axis=1)
    np.testing.assert_allclose(found.metrics["capacity_margin"], margin, rtol=1e-9)
    assert found.conditions["wrench_closure"].all()
    np.testing.assert_array_equal(found.conditions["static"], margin >= 0)


def test_split_motors_merge_to_the_same_torque() -> None:
    low, high = np.array([5.0, -3.0, 1.0, -4.0]), np.array([9.0, 2.0, 6.0, -2.0])
    L, lower, upper = split_motors(np.eye(4), low, high, 3)
    np.testing.assert_array_equal(lower, [5.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0])
    np.testing.assert_array_equal(upper, [9.0, 2.0, 6.0, 0.0, 3.0, 0.0, 4.0])
    forces = np.array([6.0, 0.0, 2.0, 0.0, 1.5, 0.0, 3.0])
    merged = merge_motors(forces, 3)
    np.testing.assert_array_equal(merged, [6.0, -1.5, 2.0, -3.0])
    np.testing.assert_array_equal(L.T @ forces, merged)


def test_negative_limits_are_valid_only_for_motors() -> None:
    arm = HybridArm()
    with pytest.raises(InputError, match=r"muscle 'd': f_min -1.0"):
        ForceDistribution(
            [0, 0, 0, -1.0, -1.0], arm.f_max, motors=1, muscle_names=(*"abcd", "elbow")
        )
    with pytest.raises(InputError, match=r"motor 'elbow': tau_min 2.0 is above tau_max 1.0"):
        ForceDistribution(
            [0, 0, 0, 0, 2.0], [1, 1, 1, 1, 1.0], motors=1, muscle_names=(*"abcd", "elbow")
        )


def test_torque_of_the_size_of_rounding_errors_is_solved() -> None:
    """A motor must produce 1e-14 N·m while muscles hold 10 N·m."""
    arm = HybridArm()
    terms = motion_terms(arm, Motion([0.0], Q[:1], np.zeros((1, 2)), np.zeros((1, 2))))
    L = terms.L.copy()
    L[0, :4, 1] = 0.0  # no muscle over the elbow
    separate = replace(terms, L=L, tau=np.array([[10.0, 2e-14]]))
    assert separate.distribute().solved.all()
