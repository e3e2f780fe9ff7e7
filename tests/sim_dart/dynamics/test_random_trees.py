"""Comparison of the core with DART, MuJoCo and Pinocchio on trees with all joint types."""

from __future__ import annotations

import numpy as np
import pytest
from support.cases import sample_cases
from support.oracles.dart_tasks import task_bias
from support.oracles.mujoco_model import MujocoRobot
from support.robots.random_robots import random_state, random_tree

from sim_dart import CoreDynamics, DartDynamics
from sim_dart.dart.skeleton import build_skeleton

TREES, GROUP = 500, 50
groups = pytest.mark.parametrize("first", sample_cases(range(0, TREES, GROUP), 2))


def deviation(found: np.ndarray, expected: np.ndarray) -> float:
    """Return the largest difference relative to the largest number."""
    scale = np.abs(expected).max(initial=0.0)
    return float(np.abs(found - expected).max(initial=0.0) / (scale or 1.0))


def check(deviations: dict[str, float], allowed: float, seed: int) -> None:
    for name, by in deviations.items():
        assert by <= allowed, f"tree {seed}: {name} is off by {by}"


@pytest.mark.native
@groups
def test_terms_equal_dart(first: int) -> None:
    for seed in range(first, first + GROUP):
        robot = random_tree(seed)
        core, dart, skeleton = CoreDynamics(robot), DartDynamics(robot), build_skeleton(robot)
        q, qd, f = random_state(robot, np.random.default_rng(seed))
        tau = -core.muscle_jacobian(q).T @ f
        skeleton.set_positions(q)
        skeleton.set_velocities(qd)
        skeleton.set_forces(tau)
        skeleton.dart.computeForwardDynamics()
        terms = {
            "M": (core.mass_matrix(q), dart.mass_matrix(q)),
            "C + G": (
                core.coriolis(q, qd) + core.gravity(q),
                dart.coriolis(q, qd) + dart.gravity(q),
            ),
            "qdd": (
                core.acceleration(q, qd, tau),
                skeleton.vector(skeleton.dart.getAccelerations()),
            ),
        }
        check({name: deviation(*pair) for name, pair in terms.items()}, 1e-12, seed)
        bias = deviation(core.task_bias(q, qd), task_bias(robot, skeleton, q, qd))
        check({"J' qd": bias}, 1e-10, seed)


@pytest.mark.slow
@groups
def test_terms_equal_mujoco(first: int) -> None:
    for seed in range(first, first + GROUP):
        robot = random_tree(seed)
        core, mujoco = CoreDynamics(robot), MujocoRobot(robot)
        q, qd, f = random_state(robot, np.random.default_rng(seed))
        mujoco.move(q, qd)
        tau = -core.muscle_jacobian(q).T @ f
        terms = {
            "l": (core.muscle_lengths(q), mujoco.lengths),
            "L": (core.muscle_jacobian(q), mujoco.jacobian),
            "M": (core.mass_matrix(q), mujoco.mass_matrix),
            "C + G": (core.coriolis(q, qd) + core.gravity(q), mujoco.bias),
            "qdd": (core.acceleration(q, qd, tau), mujoco.acceleration(tau)),
        }
        check({name: deviation(*pair) for name, pair in terms.items()}, 1e-12, seed)


@groups
@pytest.mark.extra("pinocchio")
def test_terms_equal_pinocchio(first: int) -> None:
    from support.oracles.pinocchio_model import PinocchioRobot

    for seed in range(first, first + GROUP):
        robot = random_tree(seed)
        core, pinocchio = CoreDynamics(robot), PinocchioRobot(robot)
        q, qd, f = random_state(robot, np.random.default_rng(seed))
        tau = -core.muscle_jacobian(q).T @ f
        terms = {
            "M": (core.mass_matrix(q), pinocchio.mass_matrix(q)),
            "C + G": (core.coriolis(q, qd) + core.gravity(q), pinocchio.bias(q, qd)),
            "qdd": (core.acceleration(q, qd, tau), pinocchio.acceleration(q, qd, tau)),
        }
        check({name: deviation(*pair) for name, pair in terms.items()}, 1e-12, seed)
        hand = robot.task_frames[0]
        found = pinocchio.point_bias(q, qd, hand.link, hand.position)
        check({"J' qd": deviation(core.task_bias(q, qd)[:3], found)}, 1e-10, seed)
