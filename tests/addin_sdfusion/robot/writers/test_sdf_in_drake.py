"""Drake reads written SDF files as the same robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.every_joint import every_joint
from support.robots.one_link import CASPR_ROBOTS
from support.robots.random_robots import random_robot, random_tree
from support.robots.robots import planar_2r

from addin_sdfusion.robot import read_robot, write_sdf
from sim_dart import DartDynamics

pytestmark = [pytest.mark.interop, pytest.mark.extra("drake")]

PUBLISHED = ["msj_platform", "musc-le", "shoulder_testbed", "test_robot", "theClaw"]


def assert_equal_terms(robot, folder):
    from support.oracles.drake_model import DrakeRobot

    write_sdf(robot, folder)
    drake, ours = DrakeRobot(robot, folder / "model.sdf"), DartDynamics(robot)
    damping = np.array([c.damping for c in robot.coordinates])
    rng = np.random.default_rng(1)
    for _ in range(3):
        q, qd = rng.uniform(-1, 1, (2, ours.n))
        drake.move(q, qd)
        resistance = ours.coriolis(q, qd) + ours.gravity(q) + damping * qd
        size = max(1.0, np.abs(resistance).max(initial=0.0))
        np.testing.assert_allclose(drake.mass_matrix, ours.mass_matrix(q), rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(drake.resistance / size, resistance / size, atol=1e-9)


def started(robot):
    """Return the robot with a different initial value of each coordinate."""
    joints = []
    for joint in robot.joints:
        turned = (replace(c, initial=0.1 * k) for k, c in enumerate(joint.coordinates, start=1))
        joints.append(replace(joint, coordinates=tuple(turned)))
    return replace(robot, joints=tuple(joints))


@pytest.mark.parametrize("seed", range(6))
def test_random_trees_agree(seed, tmp_path):
    assert_equal_terms(started(random_tree(seed, damping=0.3)), tmp_path)


@pytest.mark.parametrize(
    "robot",
    [planar_2r(), random_robot(0), every_joint()],
    ids=lambda robot: str(robot.name),
)
def test_all_joints_and_springs_agree(robot, tmp_path):
    assert_equal_terms(started(robot), tmp_path)


@pytest.mark.parametrize("name", CASPR_ROBOTS)
def test_caspr_models_agree(shared, name, tmp_path):
    assert_equal_terms(read_robot(shared / "robots/caspr" / name), tmp_path)


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_robots_agree(shared, name, tmp_path):
    assert_equal_terms(read_robot(shared / "robots/cardsflow" / name, repair=True), tmp_path)
