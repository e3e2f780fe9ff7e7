"""Accelerations of random trees with loops, against reduced coordinates and Pinocchio."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space
from support.cases import sample_cases
from support.oracles.loop_model import loop_acceleration, loop_jacobian
from support.robots.loops import random_loops

from addin_sdfusion.robot import Robot
from sim_dart import CoreDynamics

LOOPS, GROUP = 100, 10
groups = pytest.mark.parametrize("first", sample_cases(range(0, LOOPS, GROUP), 2))


def closed_velocities(robot: Robot, q: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return velocities that keep the loops closed, and torques."""
    rng = np.random.default_rng(seed)
    N = null_space(loop_jacobian(robot, q), rcond=1e-8)
    return N @ rng.normal(size=N.shape[1]), rng.normal(size=len(q), scale=10.0)


def assert_near(found: np.ndarray, expected: np.ndarray, seed: int) -> None:
    scale = max(1.0, float(np.abs(expected).max()))
    assert np.abs(found - expected).max() <= 1e-8 * scale, seed


@pytest.mark.native
@groups
def test_accelerations_equal_reduced_coordinates(first: int) -> None:
    for seed in range(first, first + GROUP):
        robot, q = random_loops(seed)
        qd, tau = closed_velocities(robot, q, seed)
        found = CoreDynamics(robot).acceleration(q, qd, tau)
        assert_near(found, loop_acceleration(robot, q, qd, tau), seed)


@groups
@pytest.mark.extra("pinocchio")
def test_accelerations_equal_pinocchio_constrained_dynamics(first: int) -> None:
    from support.oracles.pinocchio_model import PinocchioRobot

    for seed in range(first, first + GROUP):
        robot, q = random_loops(seed, ("fixed", "ball"))
        qd, tau = closed_velocities(robot, q, seed)
        found = CoreDynamics(robot).acceleration(q, qd, tau)
        assert_near(found, PinocchioRobot(robot).loop_acceleration(robot, q, qd, tau), seed)
