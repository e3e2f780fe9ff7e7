"""The laws in C give what the laws in Python give."""

from __future__ import annotations

import ctypes
from dataclasses import replace

import numpy as np
import pytest
from support.controllers.torque_in_c import FAILED, SOFT, SOLVED, WRONG, TorqueInC
from support.robots.random_robots import random_robot
from support.robots.robots import EXAMPLES, planar_2r

from addin_sdfusion.robot import Robot, TaskSet
from cardsflow_fmu import Experiment
from controllers import JointSpaceController, OperationalSpaceController, Posture
from controllers.dynamics import bias_torque
from controllers.qp.dual_newton import library
from sim_dart import DartDynamics

pytestmark = pytest.mark.native

KP, KD = 100.0, 20.0


def strong(seed: int) -> Robot:
    """A random robot of three joints with many muscles, so that most torques can be made."""
    return random_robot(seed, joints=3, muscles=12)


def joint_terms(
    robot: DartDynamics, q: np.ndarray, qd: np.ndarray, reference: np.ndarray
) -> dict[str, np.ndarray]:
    return {
        "M": robot.mass_matrix(q),
        "h": bias_torque(robot, q, qd),
        "L": robot.muscle_jacobian(q),
        "error": reference[0] - q,
        "rate_error": reference[1] - qd,
        "acceleration": reference[2],
    }


@pytest.mark.parametrize("seed", range(8))
def test_joint_space_in_c_equals_python(seed: int) -> None:
    robot = DartDynamics(strong(seed))
    f_p = np.linspace(0.0, 10.0 * (seed % 3), robot.m)
    python = JointSpaceController(robot, KP, KD, pretension=f_p)
    c = TorqueInC(robot.n, robot.m)
    c.write(f_p=f_p)
    c.write(kp=np.full(3, KP), kd=np.full(3, KD), H_f=np.ones(robot.m))
    c.write(f_min=robot.f_min, f_max=robot.f_max)
    c.reset()
    rng, seen = np.random.default_rng(seed), set()
    for _ in range(40):
        q, qd = rng.uniform(-1, 1, (2, 3))
        reference = rng.uniform(-3, 3, (3, 3))
        expected = python.solve(q, qd, *reference)
        status = c.solve(**joint_terms(robot, q, qd, reference))
        assert status == (SOLVED if expected.status == "solved" else SOFT)
        scale = np.abs(expected.forces).max()
        near = 1e-9 if status == SOLVED else 1e-7  # softly, the cost of forces is next to nothing
        np.testing.assert_allclose(c.array("forces"), expected.forces, rtol=0, atol=near * scale)
        np.testing.assert_allclose(c.array("slack"), expected.slack, rtol=0, atol=1e-7 * scale)
        seen.add(status)
    assert SOLVED in seen


@pytest.mark.parametrize("norm", [3, 4, 8])
def test_norms_in_c_equal_python(norm: int) -> None:
    """Forces that count next to nothing beside the largest ones are known less well."""
    robot = DartDynamics(strong(7))
    f_p, H = np.linspace(0.0, 8.0, robot.m), np.linspace(1.0, 3.0, robot.m)
    python = JointSpaceController(robot, KP, KD, weights=H, norm=norm, pretension=f_p)
    c = TorqueInC(robot.n, robot.m)
    c.write(kp=np.full(3, KP), kd=np.full(3, KD), H_f=H, f_p=f_p, norm=norm)
    c.write(f_min=robot.f_min, f_max=robot.f_max)
    c.reset()
    rng, statuses = np.random.default_rng(norm), []
    for _ in range(40):
        q, qd = rng.uniform(-1, 1, (2, 3))
        reference = rng.uniform(-1, 1, (3, 3))
        expected = python.solve(q, qd, *reference)
        status = c.solve(**joint_terms(robot, q, qd, reference))
        assert status == (SOLVED if expected.status == "solved" else SOFT)
        if status == SOLVED:
            of_c, of_python = (
                np.linalg.norm(np.sqrt(H) * (forces - f_p), norm)
                for forces in (c.array("forces"), expected.forces)
            )
            assert of_c == pytest.approx(of_python, rel=1e-12)
            np.testing.assert_allclose(c.array("forces"), expected.forces, rtol=0, atol=1e-4)
            np.testing.assert_allclose(c.array("slack"), 0.0, atol=1e-6)
        statuses.append(status)
    assert statuses.count(SOLVED) > 20


def test_where_no_force_fits_the_acceleration_errs_least() -> None:
    """An arm asked for more than its muscles give, at many states."""
    robot = DartDynamics(planar_2r())
    python, c = JointSpaceController(robot, 2000.0, 90.0), TorqueInC(robot.n, robot.m)
    c.write(kp=[2000.0] * 2, kd=[90.0] * 2, H_f=np.ones(robot.m))
    c.write(f_min=robot.f_min, f_max=np.full(robot.m, 60.0))
    python.set_bounds(robot.f_min, [60.0] * robot.m)
    rng, soft = np.random.default_rng(0), 0
    for _ in range(60):
        q, qd = rng.uniform(-1, 1, (2, 2))
        reference = rng.uniform(-1, 1, (3, 2))
        expected = python.solve(q, qd, *reference)
        status = c.solve(**joint_terms(robot, q, qd, reference))
        assert status == (SOLVED if expected.status == "solved" else SOFT)
        np.testing.assert_allclose(c.array("forces"), expected.forces, rtol=0, atol=1e-6)
        soft += status == SOFT
    assert soft > 10


def hand_only(seed: int) -> Robot:
    """A random robot with a single point to move."""
    robot = random_robot(seed, joints=4, muscles=14)
    hand = TaskSet("hand", robot.task_frames[:1])
    return replace(robot, task_sets=(hand,), task_set="hand")


def compare_operational(
    described: Robot, rng: np.random.Generator, weight: float, around: float | np.ndarray = 0.0
) -> list[int]:
    """Both laws at random states with references near them; the statuses."""
    robot = DartDynamics(described)
    n, m, k = robot.n, robot.m, len(robot.task_names)
    posture = Posture(kd=5.0, kp=30.0, q0=np.full(n, 0.1))
    python = OperationalSpaceController(
        robot, KP, KD, posture=posture, task_weights=weight, force_rate_weights=1e-7, pretension=6.0
    )
    c = TorqueInC(n, m, k)
    c.write(kp=np.full(k, KP), kd=np.full(k, KD), f_min=robot.f_min, f_max=robot.f_max)
    c.write(H_q=np.ones(n), H_f=np.full(m, 1e-6), H_r=np.full(m, 1e-7), f_p=np.full(m, 6.0))
    c.write(W=np.full(k, weight), posture_kp=np.full(n, 30.0), posture_kd=np.full(n, 5.0))
    c.write(q0=np.full(n, 0.1), q_min=robot.q_min, q_max=robot.q_max, limit_bandwidth=20.0)
    c.reset()
    statuses = []
    for _ in range(25):
        q, qd = rng.uniform(-0.3, 0.3, (2, n))
        q += around
        y, J = robot.task_position(q), robot.task_jacobian(q)
        reference = np.array([y, J @ qd, rng.uniform(-1, 1, k)])
        reference[:2] += rng.uniform(-0.05, 0.05, (2, k))
        expected = python.solve(q, qd, *reference)
        status = c.solve(
            M=robot.mass_matrix(q),
            h=bias_torque(robot, q, qd),
            L=robot.muscle_jacobian(q),
            J=J,
            bias=robot.task_bias(q, qd),
            error=python.error(q, reference[0]),
            rate_error=reference[1] - J @ qd,
            acceleration=reference[2],
            q=q,
            qd=qd,
        )
        assert status == (SOLVED if expected.status == "solved" else SOFT)
        scale = np.abs(expected.forces).max()
        near = 1e-8 if status == SOLVED else 1e-5
        np.testing.assert_allclose(c.array("forces"), expected.forces, rtol=0, atol=near * scale)
        assert bool(c.array("limits_dropped")[0]) == expected.limits_dropped
        statuses.append(status)
    return statuses


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("weight", [np.inf, 10.0])
def test_operational_space_in_c_equals_python(seed: int, weight: float) -> None:
    compare_operational(hand_only(seed), np.random.default_rng(seed), weight)


def test_operational_space_of_an_arm_with_strong_muscles() -> None:
    arm = Experiment.load(EXAMPLES / "roboy_left_arm")
    muscles = [replace(muscle, f_max=5000.0) for muscle in arm.robot.muscles]
    rng, start = np.random.default_rng(0), np.array(arm.start.q)
    statuses = compare_operational(arm.robot.with_muscles(muscles), rng, np.inf, start)
    assert statuses.count(SOLVED) > 15


def test_wrong_numbers_are_refused_and_leave_the_forces() -> None:
    robot = DartDynamics(planar_2r())
    c = TorqueInC(robot.n, robot.m)
    c.write(kp=[1.0] * 2, kd=[1.0] * 2, H_f=np.ones(4), f_min=robot.f_min, f_max=robot.f_max)
    c.reset()
    zeros = np.zeros(2)
    terms = joint_terms(robot, zeros, zeros, np.zeros((3, 2)))
    assert c.solve(**terms) in (SOLVED, SOFT)
    forces = c.array("forces").copy()
    for name in ("h", "M", "error", "L"):
        assert c.solve(**terms | {name: np.full_like(terms[name], np.nan)}) in (WRONG, FAILED)
        assert np.array_equal(c.array("forces"), forces)
    assert c.solve(**terms) in (SOLVED, SOFT)


def test_sizes_are_checked() -> None:
    size = library().computed_torque_size
    size.restype = ctypes.c_size_t
    assert size(2, 4, 0) > 0
    for wrong in ((0, 4, 0), (2, 0, 0), (2, 4, -1), (5000, 4, 0), (2, 5000, 0)):
        assert size(*wrong) == 0
