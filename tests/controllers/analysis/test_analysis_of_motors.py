"""Analysis of robots with motors at joints, against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.arms import TwoLinkArm

from addin_sdfusion.robot import InputError
from controllers import CableVelocityController, ForceDistribution
from controllers.analysis.inverse_dynamics import Motion, motion_terms, size_muscles
from controllers.analysis.linearise import linearise_robot
from controllers.analysis.workspace import workspace
from controllers.force_distribution.gravity_compensation import gravity_compensation
from controllers.force_distribution.methods import METHODS
from controllers.force_distribution.motor_columns import merge_motors, split_motors

Q = np.array([[0.3, -0.4], [1.0, 0.5], [-0.7, 1.1]])


MISSING = ("closed_form", "puncture")
"""They may miss a solution where forces are at their bounds."""


class HybridArm(TwoLinkArm):
    """Two muscles at the shoulder, two over both joints; a motor at the elbow."""

    motor_names = ("elbow",)
    f_min = np.array([5.0, 5.0, 5.0, 5.0, -20.0])
    f_max = np.array([5000.0, 5000.0, 5000.0, 5000.0, 30.0])

    def actuator_jacobian(self, q):
        return np.vstack([self.muscle_jacobian(q), [0.0, -1.0]])


class MotorArm(HybridArm):
    """Motors alone."""

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


def test_motors_alone_make_what_is_asked(motion: Motion) -> None:
    arm = MotorArm()
    terms = motion_terms(arm, motion)
    found = terms.distribute()
    np.testing.assert_allclose(found.forces, terms.tau, atol=1e-9)
    np.testing.assert_allclose(gravity_compensation(arm, Q[0]), arm.gravity(Q[0]), atol=1e-9)
    down, up = found.torque_margins
    np.testing.assert_allclose(down, terms.tau - arm.f_min, rtol=1e-9)
    np.testing.assert_allclose(up, arm.f_max - terms.tau, rtol=1e-9)


def test_what_motors_need_is_the_largest_torque_either_way() -> None:
    arm = MotorArm()
    upside_down = np.array([[np.pi, 0.0]])
    terms = motion_terms(arm, Motion([0.0], upside_down, np.zeros((1, 2)), np.zeros((1, 2))))
    assert (terms.tau < 0).all()
    np.testing.assert_allclose(size_muscles(terms).needed, 1.2 * np.abs(terms.tau[0]), rtol=1e-9)


ALL = sorted(name for name in METHODS if name not in MISSING and "polygon" not in name)


@pytest.mark.parametrize("method", ALL)
def test_every_method_drives_motors_both_ways(method: str, motion: Motion) -> None:
    arm = HybridArm()
    terms = motion_terms(arm, motion).with_bounds(None, [500.0, 500.0, 500.0, 500.0, 30.0])
    found = terms.distribute(method)
    assert found.solved.all()
    L = np.array([arm.actuator_jacobian(q) for q in Q])
    made = -np.einsum("tan,ta->tn", L, found.forces)
    np.testing.assert_allclose(made, terms.tau, atol=1e-6)
    assert (found.forces >= arm.f_min - 1e-6).all()


def test_the_least_sum_counts_the_size_of_a_torque() -> None:
    """One coordinate and one motor of tau < 0: the least sum is |tau|, not tau_min."""
    terms = motion_terms(MotorArm(), Motion([0.0], [[np.pi, 0.0]], [[0.0, 0.0]], [[0.0, 0.0]]))
    np.testing.assert_allclose(terms.distribute("linear_programme").forces, terms.tau, rtol=1e-9)


def test_least_squares_are_those_of_the_controller(motion: Motion) -> None:
    arm = HybridArm()
    terms = motion_terms(arm, motion)
    distribution = ForceDistribution(arm.f_min, arm.f_max, motors=1)
    for L, tau, forces in zip(terms.L, terms.tau, terms.distribute().forces, strict=True):
        np.testing.assert_allclose(distribution.solve(L, tau).forces, forces, atol=1e-7)


def test_linear_robots_are_driven_by_motors() -> None:
    arm = HybridArm()
    linear = linearise_robot(arm, Q[0], np.zeros(2), gravity_compensation(arm, Q[0]))
    np.testing.assert_allclose(
        linear.B[2:, 4], np.linalg.solve(arm.mass_matrix(Q[0]), [0.0, 1.0]), rtol=1e-12
    )


def test_workspace_of_motors_is_the_box_of_their_torques() -> None:
    arm = MotorArm()
    found = workspace(arm, Q, metrics=["capacity_margin"])
    G = np.array([arm.gravity(q) for q in Q])
    margin = np.minimum(G - arm.f_min, arm.f_max - G).min(axis=1)
    np.testing.assert_allclose(found.metrics["capacity_margin"], margin, rtol=1e-9)
    assert found.conditions["wrench_closure"].all()
    np.testing.assert_array_equal(found.conditions["static"], margin >= 0)


def test_two_pulls_are_one_torque() -> None:
    low, high = np.array([5.0, -3.0, 1.0, -4.0]), np.array([9.0, 2.0, 6.0, -2.0])
    L, least, most = split_motors(np.eye(4), low, high, 3)
    np.testing.assert_array_equal(least, [5.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0])
    np.testing.assert_array_equal(most, [9.0, 2.0, 6.0, 0.0, 3.0, 0.0, 4.0])
    forces = np.array([6.0, 0.0, 2.0, 0.0, 1.5, 0.0, 3.0])
    folded = merge_motors(forces, 3)
    np.testing.assert_array_equal(folded, [6.0, -1.5, 2.0, -3.0])
    np.testing.assert_array_equal(L.T @ forces, folded)


def test_muscles_do_not_push_where_motors_do() -> None:
    arm = HybridArm()
    with pytest.raises(InputError, match=r"muscle 'd': f_min -1.0"):
        ForceDistribution(
            [0, 0, 0, -1.0, -1.0], arm.f_max, motors=1, muscle_names=(*"abcd", "elbow")
        )
    with pytest.raises(InputError, match=r"motor 'elbow': tau_min 2.0 is above tau_max 1.0"):
        ForceDistribution(
            [0, 0, 0, 0, 2.0], [1, 1, 1, 1, 1.0], motors=1, muscle_names=(*"abcd", "elbow")
        )


def test_cable_velocities_drive_no_motors() -> None:
    with pytest.raises(InputError, match="does not support motors at joints: elbow"):
        CableVelocityController(HybridArm(), 1.0)


def test_a_torque_that_is_rounding_beside_the_others_is_no_reason_to_fail() -> None:
    """A motor that has nothing to do but 1e-14 N·m, beside muscles that hold 10 N·m."""
    arm = HybridArm()
    terms = motion_terms(arm, Motion([0.0], Q[:1], np.zeros((1, 2)), np.zeros((1, 2))))
    L = terms.L.copy()
    L[0, :4, 1] = 0.0  # no muscle over the elbow
    alone = replace(terms, L=L, tau=np.array([[10.0, 2e-14]]))
    assert alone.distribute().solved.all()
