from __future__ import annotations

import numpy as np
import pytest
from support.oracles.mujoco_model import MujocoRobot
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError, Robot
from sim_dart import MusclePaths

pytestmark = pytest.mark.native

ROBOTS = [
    *(planar_2r(name) for name in ("basic", "basic_multi_segment", "basic_2018_07")),
    *(random_robot(seed) for seed in range(20)),
    random_robot(99, joints=20, muscles=60),
]


def states(robot: Robot, count: int = 10) -> np.ndarray:
    return np.random.default_rng(1).uniform(-1.5, 1.5, (count, len(robot.coordinates)))


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda r: f"{r.name}-{r.cable_set}")
def test_lengths_and_jacobian_equal_mujoco_spatial_tendons(robot: Robot) -> None:
    paths, mujoco = MusclePaths(robot), MujocoRobot(robot, inertias=False)
    for q in states(robot):
        mujoco.move(q)
        state = paths.evaluate(q)
        np.testing.assert_allclose(state.lengths, mujoco.lengths, rtol=0, atol=1e-12)
        np.testing.assert_allclose(state.jacobian, mujoco.jacobian, rtol=0, atol=1e-12)


@pytest.mark.parametrize("robot", ROBOTS[:8], ids=lambda r: f"{r.name}-{r.cable_set}")
def test_jacobian_is_the_derivative_of_the_lengths(robot: Robot) -> None:
    paths, h = MusclePaths(robot), 1e-6
    for q in states(robot):
        L = paths.evaluate(q).jacobian.copy()
        for j, e in enumerate(np.eye(q.size) * h):
            ahead = paths.evaluate(q + e).lengths.copy()
            slope = (ahead - paths.evaluate(q - e).lengths) / (2 * h)
            np.testing.assert_allclose(L[:, j], slope, rtol=0, atol=2e-8)


@pytest.mark.parametrize("robot", ROBOTS[3:8], ids=lambda r: r.name)
def test_task_jacobian_is_the_derivative_of_the_task_coordinates(robot: Robot) -> None:
    paths, h = MusclePaths(robot), 1e-6
    for q in states(robot, 3):
        J = paths.task_jacobian(q)
        for j, e in enumerate(np.eye(q.size) * h):
            slope = (paths.task_position(q + e) - paths.task_position(q - e)) / (2 * h)
            np.testing.assert_allclose(J[:, j], slope, rtol=0, atol=2e-8)


def test_muscle_within_one_link_has_no_moment_arm() -> None:
    robot = planar_2r()
    muscle = robot.muscles[0]
    here = muscle.via_points[1]
    there = type(here)(here.link, (0.0, 0.0, 0.0))
    inner = type(muscle)("inner", (here, there), 1.0, 2.0)
    paths = MusclePaths(robot.with_muscles([inner]))
    state = paths.evaluate([0.3, -0.4])
    assert state.lengths[0] == pytest.approx(np.linalg.norm(here.position), abs=1e-15)
    assert not state.jacobian.any()


@pytest.mark.parametrize("q", [[0.0], [0.0, 0.0, 0.0], [[0.0, 0.0]], "ab", None])
def test_wrong_shape_of_q_is_rejected(q: object) -> None:
    with pytest.raises(InputError, match="q must"):
        MusclePaths(planar_2r()).evaluate(q)  # type: ignore[arg-type]
