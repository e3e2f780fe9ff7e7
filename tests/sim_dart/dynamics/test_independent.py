"""Dynamics in independent coordinates for robots with loops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import null_space
from support.cases import sample_cases
from support.oracles.loop_model import loop_acceleration, loop_jacobian
from support.robots.loops import five_bar, four_bar, random_loops, with_loop

from addin_sdfusion.robot import InputError, Pose, Robot, SimulationError
from controllers.dynamics import acceleration
from sim_dart import CoreDynamics, IndependentDynamics, close_loops, dependent_coordinates
from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native

groups = pytest.mark.parametrize("first", sample_cases(range(0, 40, 10)))


def closed_velocities(robot: Robot, q: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return velocities that keep the loops closed."""
    N = null_space(loop_jacobian(robot, q), rcond=1e-8)
    return np.asarray(N @ rng.normal(size=N.shape[1]))


def cases(first: int) -> list[tuple[Robot, FloatArray, IndependentDynamics]]:
    found = []
    for seed in range(first, first + 10):
        robot, q = random_loops(seed)
        rows = loop_jacobian(robot, q)
        if not 0 < np.linalg.matrix_rank(rows, 1e-8) < len(q):
            continue
        dynamics = IndependentDynamics(robot, independent_at(rows))
        found.append((robot, q, dynamics))
    return found


def independent_at(J: FloatArray) -> FloatArray:
    """Return dependent coordinates for a pose from a pivoted QR decomposition."""
    from scipy.linalg import qr

    rank, (_, _, order) = np.linalg.matrix_rank(J, 1e-8), qr(J, pivoting=True)
    flags = np.zeros(J.shape[1])
    flags[order[:rank]] = 1.0
    return flags


@groups
def test_accelerations_equal_reduced_coordinates(first: int) -> None:
    for seed, (robot, q, dynamics) in enumerate(cases(first)):
        rng = np.random.default_rng(seed)
        qd, tau = closed_velocities(robot, q, rng), rng.normal(size=len(q), scale=10.0)
        none = np.zeros(len(dynamics.actuator_jacobian(q)))
        damping = np.array([c.damping for c in robot.coordinates]) * qd
        found = acceleration(dynamics, q, qd, none, dynamics.load(q, -tau))
        expected = loop_acceleration(robot, q, qd, tau - damping)
        scale = max(1.0, float(np.abs(expected).max()))
        assert np.abs(found - expected).max() <= 1e-8 * scale


def test_n_is_the_derivative_of_dependent_coordinates() -> None:
    """Compare N with finite differences of the closed pose."""
    robot, step = five_bar(), 1e-6
    dynamics = IndependentDynamics(robot)
    q = dynamics.closed([c.initial for c in robot.coordinates])
    N = dynamics.free_motion(q)
    for k in np.flatnonzero(~dynamics.dependent):
        ends = [dynamics.closed(q + side * step * np.eye(4)[k]) for side in (1, -1)]
        np.testing.assert_allclose((ends[0] - ends[1]) / (2 * step), N[:, k], atol=1e-8)


def test_robots_without_loops_have_no_dependent_coordinates() -> None:
    tree = replace(four_bar(), loops=())
    assert dependent_coordinates(tree) == (False,) * 3
    assert not CoreDynamics(tree).dependent.any()


def test_redundant_loops_add_no_dependent_coordinates() -> None:
    """The loop is a ball joint at the position of an existing hinge."""
    places = {"T_parent_joint": Pose((0.2, 0.0, 0.0)), "T_child_joint": Pose()}
    ends = {"parent": "crank_bar", "child": "coupler_bar", "type": "ball", "axes": ()}
    robot = with_loop(four_bar(), **ends, **places)
    tree = CoreDynamics(replace(robot, loops=()))
    dynamics = IndependentDynamics(robot)
    assert not dynamics.dependent.any()
    q = np.array([0.3, -0.4, 0.5])
    np.testing.assert_allclose(dynamics.mass_matrix(q), tree.mass_matrix(q), atol=1e-15)
    np.testing.assert_allclose(dynamics.coriolis(q, q), tree.coriolis(q, q), atol=1e-15)


def test_required_and_excluded_coordinates_are_respected() -> None:
    assert dependent_coordinates(four_bar(), excluded=["crank"]) == (False, True, True)
    assert dependent_coordinates(four_bar(), required=["crank"])[0]
    with pytest.raises(InputError, match="crank dependent, coupler dependent, rocker dependent"):
        dependent_coordinates(four_bar(), required=["crank", "coupler", "rocker"])
    with pytest.raises(InputError, match="crank independent, coupler independent"):
        dependent_coordinates(four_bar(), excluded=["crank", "coupler"])


def test_loops_that_cannot_be_closed_are_rejected() -> None:
    far = with_loop(four_bar(), T_child_joint=Pose((5.0, 0.0, 0.0)))
    with pytest.raises(InputError, match="loop cannot be closed"):
        dependent_coordinates(far)


def test_singular_pose_is_reported() -> None:
    """If crank and coupler are collinear, the rocker does not determine their velocities."""
    robot = four_bar((0.2, 0.5, 0.4, 0.5))
    dynamics = IndependentDynamics(robot, [True, True, False])
    reach = 0.2 + 0.5  # crank and coupler in line
    rocker = np.arccos((0.5**2 + 0.4**2 - reach**2) / (2 * 0.5 * 0.4))
    crank = np.arccos((0.5**2 + reach**2 - 0.4**2) / (2 * 0.5 * reach))
    q = np.array([-crank, 0.0, -(np.pi - rocker)])
    assert np.abs(close_loops(robot, q) - q).max() <= 1e-9
    with pytest.raises(SimulationError, match="is not determined by the independent coordinates"):
        dynamics.free_motion(q)
