"""Tests of forward and inverse kinematics."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError, Robot, TaskFrame, TaskSet, read_robot
from controllers.analysis.kinematics import forward_kinematics, inverse_kinematics
from sim_dart import DartDynamics


def limited(robot: Robot, lower: float, upper: float) -> Robot:
    """Return the robot with equal limits for all coordinates."""
    joints = tuple(
        replace(
            joint,
            coordinates=tuple(replace(c, lower=lower, upper=upper) for c in joint.coordinates),
        )
        for joint in robot.joints
    )
    return replace(robot, joints=joints)


@pytest.fixture
def left_arm(shared: Path) -> DartDynamics:
    return DartDynamics(read_robot(shared / "robots/caspr/RoboyLeftArm", "DEFAULT"))


def test_lengths_determine_the_configuration_of_the_two_link_arm(arm: DartDynamics) -> None:
    rng = np.random.default_rng(0)
    for q in rng.uniform(-0.8, 0.8, (20, 2)):
        found = forward_kinematics(arm, arm.muscle_lengths(q), q + rng.uniform(-0.2, 0.2, 2))
        np.testing.assert_allclose(found.q, q, atol=1e-10)
        assert found.error < 1e-12
        assert found.determined


def test_lengths_determine_the_configuration_of_the_left_arm(left_arm: DartDynamics) -> None:
    rng = np.random.default_rng(1)
    low, high = np.array([1.2, -0.8, -0.5, -1.4]), np.array([1.7, 0.8, 0.5, 0.0])
    for q in rng.uniform(low, high, (20, 4)):
        start = q + rng.uniform(-0.2, 0.2, 4)
        found = forward_kinematics(left_arm, left_arm.muscle_lengths(q), start)
        np.testing.assert_allclose(found.q, q, atol=1e-9)
        assert (found.q >= left_arm.q_min).all()
        assert (found.q <= left_arm.q_max).all()


@pytest.mark.parametrize("seed", range(3))
def test_lengths_determine_the_configuration_of_random_trees(seed: int) -> None:
    robot = DartDynamics(random_robot(seed, joints=4, muscles=10))
    rng = np.random.default_rng(seed)
    for q in rng.uniform(-1, 1, (4, 4)):
        found = forward_kinematics(robot, robot.muscle_lengths(q), q + rng.uniform(-0.1, 0.1, 4))
        assert found.error < 1e-10
        if found.determined and np.linalg.cond(robot.muscle_jacobian(q)) < 1e3:
            np.testing.assert_allclose(found.q, q, atol=1e-7)


def test_inconsistent_lengths_leave_a_residual(arm: DartDynamics) -> None:
    lengths = arm.muscle_lengths([0.1, 0.2]) + np.array([0.1, 0.0, 0.1, 0.0])
    found = forward_kinematics(arm, lengths, [0.0, 0.0])
    assert found.error > 0.02
    slope = arm.muscle_jacobian(found.q).T @ found.residual
    np.testing.assert_allclose(slope, 0.0, atol=1e-8)  # a local minimum


def test_additional_starts_find_the_configuration() -> None:
    arm = DartDynamics(limited(planar_2r(), -1.5, 1.5))
    lengths = arm.muscle_lengths([0.9, -1.2])
    far = forward_kinematics(arm, lengths, [-1.5, 1.5], starts=20)
    assert far.error < 1e-12
    np.testing.assert_allclose(far.q, [0.9, -1.2], atol=1e-9)


def test_task_is_reached_near_the_posture(left_arm: DartDynamics) -> None:
    """The arm is redundant. SLSQP does not find a configuration nearer to the posture."""
    rng = np.random.default_rng(2)
    low, high = left_arm.q_min, left_arm.q_max
    posture = np.array([1.45, 0.0, 0.0, -1.3])
    for q in rng.uniform(low, high, (6, 4)):
        y = left_arm.task_position(q)
        found = inverse_kinematics(left_arm, y, posture)
        np.testing.assert_allclose(left_arm.task_position(found.q), y, atol=1e-8)
        np.testing.assert_allclose(found.error, y - left_arm.task_position(found.q), atol=1e-15)
        best = minimize(
            lambda x: np.sum((x - posture) ** 2),
            found.q,
            jac=lambda x: 2 * (x - posture),
            bounds=list(zip(low, high, strict=True)),
            constraints={
                "type": "eq",
                "fun": lambda x, y=y: left_arm.task_position(x) - y,
                "jac": lambda x: left_arm.task_jacobian(x),
            },
            options={"ftol": 1e-14},
        )
        assert np.sum((found.q - posture) ** 2) <= best.fun + 1e-5
        assert (found.q >= low).all()
        assert (found.q <= high).all()


def test_start_pose_on_the_flower_is_found(left_arm: DartDynamics) -> None:
    start = inverse_kinematics(left_arm, [0.6, -0.45, 0.45], [1.45, 0.0, 0.0, -1.3])
    np.testing.assert_allclose(left_arm.task_position(start.q), [0.6, -0.45, 0.45], atol=1e-8)
    assert start.at_limits == ()


@pytest.mark.parametrize("seed", range(4))
def test_positions_and_orientations_of_random_trees_are_reached(seed: int) -> None:
    robot = DartDynamics(limited(random_robot(seed), -1.5, 1.5))
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1, 1, robot.n)
    found = inverse_kinematics(robot, robot.task_position(q), q + rng.uniform(-0.1, 0.1, robot.n))
    assert np.abs(found.error).max() < 1e-8


def test_angle_errors_are_wrapped() -> None:
    robot = planar_2r()
    tasks = TaskSet("turn", (TaskFrame("tip", robot.links[-1].name, axes=("beta",)),))
    arm = DartDynamics(replace(robot, task_sets=(tasks,), task_set="turn"))
    y = arm.task_position([0.2, 0.3])
    found = inverse_kinematics(arm, y + 2 * np.pi, [0.2, 0.2])
    np.testing.assert_allclose(arm.task_position(found.q), y, atol=1e-8)


def test_unreachable_position_raises_an_error_with_the_distance(arm: DartDynamics) -> None:
    """Two links of 1 m reach 2 m, so that the error is 0.5 m."""
    with pytest.raises(InputError, match=r"tip\.x 0, tip\.z 2\.5: .* distance 0\.5 m") as caught:
        inverse_kinematics(arm, [0.0, 2.5], [0.1, 0.1], starts=2)
    assert "at no limit" in str(caught.value)
    with pytest.raises(InputError, match="distance inf m"):
        inverse_kinematics(arm, [1e308, 1e308], [0.3, 0.3])


def test_error_names_active_limits() -> None:
    arm = DartDynamics(limited(planar_2r(), -0.3, 0.3))
    with pytest.raises(InputError, match=r"at the limits of joint_1, joint_2"):
        inverse_kinematics(arm, [2.0, 0.0], [0.0, 0.0], starts=3)


def test_locked_coordinate_does_not_move() -> None:
    robot = planar_2r()
    first = robot.joints[0]
    locked = replace(first.coordinates[0], lower=0.2, upper=0.2)
    joints = (replace(first, coordinates=(locked,)), *robot.joints[1:])
    frame = robot.task_frames[0]
    tasks = TaskSet("one", (replace(frame, axes=("x",)),))
    arm = DartDynamics(replace(robot, joints=joints, task_sets=(tasks,), task_set="one"))
    y = arm.task_position([0.2, 0.5])
    found = inverse_kinematics(arm, y, [0.0, 0.3])
    np.testing.assert_allclose(found.q, [0.2, 0.5], atol=1e-7)
    assert found.at_limits == ("joint_1",)
    back = forward_kinematics(arm, arm.muscle_lengths([0.2, 0.5]), [0.0, 0.3])
    np.testing.assert_allclose(back.q, [0.2, 0.5], atol=1e-9)


def test_wrong_input_raises_an_error(arm: DartDynamics) -> None:
    with pytest.raises(InputError, match="lengths must be 4"):
        forward_kinematics(arm, [1.0], [0.0, 0.0])
    with pytest.raises(InputError, match="q_start must be 2 finite"):
        forward_kinematics(arm, np.ones(4), [0.0, np.nan])
    with pytest.raises(InputError, match="starts must be"):
        forward_kinematics(arm, np.ones(4), [0.0, 0.0], starts=0)
    for change in ({"y": [0.0]}, {"posture": [0.0]}, {"tolerance": 0.0}, {"q_start": "no"}):
        arguments: dict[str, object] = {"y": [0.5, 1.0], "q_start": [0.1, 0.1]} | change
        with pytest.raises(InputError, match=next(iter(change))):
            inverse_kinematics(arm, **arguments)  # type: ignore[arg-type]
