from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.plants import check_repeats, steps
from support.robots.random_robots import random_robot
from support.robots.robots import chain, planar_2r, with_coordinates

from addin_sdfusion.robot import InputError, Robot, RobotError, TaskFrame, TaskSet
from sim_dart import DartDynamics, Plant
from sim_dart.dart.skeleton import Skeleton
from sim_dart.plant.dart_mechanism import DartMechanism

pytestmark = pytest.mark.usefixtures("every_engine")


@pytest.mark.parametrize("seed", range(5))
def test_step_equals_semi_implicit_euler(seed: int) -> None:
    """Compare with qd+ = qd + h M^-1 (-L'f - C - G), q+ = q + h qd+."""
    robot, h = random_robot(seed), 1e-3
    plant, terms = Plant(robot, step=h), DartDynamics(robot)
    rng = np.random.default_rng(seed)
    q, qd = rng.uniform(-1, 1, (2, len(robot.coordinates)))
    f = rng.uniform(5, 50, len(robot.muscles))
    plant.reset(q, qd)
    plant.step(f)
    tau = -terms.muscle_jacobian(q).T @ f - terms.coriolis(q, qd) - terms.gravity(q)
    expected = qd + h * np.linalg.solve(terms.mass_matrix(q), tau)
    np.testing.assert_allclose(plant.qd, expected, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(plant.q, q + h * expected, rtol=0, atol=1e-12)
    assert plant.time == h


def test_joint_motors_add_their_torque() -> None:
    """Check M qdd = -L'f + A tau - C - G with a motor only at the second joint."""
    first, second = planar_2r().joints
    motor = replace(second.coordinates[0], actuated=True)
    robot = replace(planar_2r(), joints=(first, replace(second, coordinates=(motor,))))
    plant, terms, h = Plant(robot), DartDynamics(robot), 1e-3
    f, tau, zero = np.full(4, 10.0), np.array([0.7]), np.zeros(2)
    plant.step(f, tau)
    pull = -terms.muscle_jacobian(zero).T @ f + terms.actuation @ tau - terms.gravity(zero)
    expected = h * np.linalg.solve(terms.mass_matrix(zero), pull)
    np.testing.assert_allclose(plant.qd, expected, rtol=1e-12, atol=1e-14)
    for wrong in ([], [np.nan], [1.0, 2.0]):
        with pytest.raises(InputError, match="torques"):
            plant.step(f, wrong)


def test_lengths_follow_the_state() -> None:
    robot = random_robot(3)
    plant, terms = Plant(robot), DartDynamics(robot)
    for _ in range(20):
        plant.step(np.full(len(robot.muscles), 20.0))
        np.testing.assert_allclose(plant.muscle_lengths, terms.muscle_lengths(plant.q), atol=1e-15)
        np.testing.assert_allclose(
            plant.muscle_jacobian, terms.muscle_jacobian(plant.q), atol=1e-15
        )


def energy(terms: DartDynamics, robot: Robot, q: np.ndarray, qd: np.ndarray) -> float:
    """Return the total energy of the two-link arm."""
    z1 = 0.5 * np.cos(q[0])
    z2 = np.cos(q[0]) + 0.5 * np.cos(q[0] + q[1])
    return float(0.5 * qd @ terms.mass_matrix(q) @ qd + 0.1 * 9.81 * (z1 + z2))


def test_energy_of_the_free_arm_drifts_with_the_first_order_of_the_step() -> None:
    robot = with_coordinates(planar_2r(), lower=-np.inf, upper=np.inf)
    terms = DartDynamics(robot)
    drift = []
    for h in (2e-3, 1e-3):
        plant = Plant(robot, step=h)
        plant.reset([2.6, 0.3])
        start = energy(terms, robot, plant.q, plant.qd)
        worst = 0.0
        for _ in range(round(2 / h)):
            plant.step(np.zeros(4))
            worst = max(worst, abs(energy(terms, robot, plant.q, plant.qd) - start))
        drift.append(worst)
    assert drift[1] < 5e-3
    assert drift[0] / drift[1] == pytest.approx(2.0, rel=0.1)


def test_damping_is_integrated_implicitly() -> None:
    """Compare with qd+ = qd + h (M + h D)^-1 (-C - G - D qd)."""
    robot, h, d = with_coordinates(planar_2r(), damping=1.0), 1e-3, 1.0
    plant, terms = Plant(robot, step=h), DartDynamics(robot)
    q, qd = np.array([0.3, -0.2]), np.array([1.0, -2.0])
    plant.reset(q, qd)
    plant.step(np.zeros(4))
    M, D = terms.mass_matrix(q), d * np.eye(2)
    tau = -terms.coriolis(q, qd) - terms.gravity(q) - D @ qd
    np.testing.assert_allclose(plant.qd, qd + h * np.linalg.solve(M + h * D, tau), rtol=1e-10)


def test_limits_stop_a_falling_arm() -> None:
    stopped = Plant(with_coordinates(planar_2r(), lower=-0.4, upper=0.4))
    free = Plant(with_coordinates(planar_2r(), lower=-np.inf, upper=np.inf))
    for plant in (stopped, free):
        plant.reset([0.3, 0.1])
        for _ in range(1500):
            plant.step(np.zeros(4))
            if plant is stopped:
                assert np.all(np.abs(plant.q) <= 0.4 + 1e-9)
    assert np.abs(free.q).max() > 1.0


def test_resting_robot_is_not_deactivated() -> None:
    """A force after ten seconds of rest moves the robot immediately."""
    robot = replace(planar_2r(), gravity=(0.0, 0.0, 0.0))
    plant = Plant(robot)
    steps(plant, 10_000, np.zeros(4))
    plant.step([0.0, 0.0, 1e-3, 0.0])
    assert plant.qd[0] != 0.0


def test_a_cable_cannot_push() -> None:
    plant, slack = Plant(planar_2r()), Plant(planar_2r())
    plant.step([-50.0, 10.0, -1.0, 10.0])
    slack.step([0.0, 10.0, 0.0, 10.0])
    assert np.array_equal(plant.get_state(), slack.get_state())


def test_state_is_restored_bit_identically() -> None:
    plant = Plant(chain())
    f = np.random.default_rng(0).uniform(1, 5, 60)
    steps(plant, 30, f)
    check_repeats(plant, 30, f)
    assert plant.time == 60 * plant.step_size


@pytest.mark.parametrize(
    ("forces", "message"),
    [
        ([1.0, 2.0], "shape"),
        (10.0, "shape"),
        ([1.0, np.nan, 1.0, 1.0], "cable_2.*not finite"),
        ([1.0, 1.0, 1.0, np.inf], "cable_4.*not finite"),
        (["a", "b", "c", "d"], "4 numbers"),
    ],
)
def test_invalid_forces_are_rejected_without_changing_the_plant(
    forces: object, message: str
) -> None:
    plant = Plant(planar_2r())
    before = plant.get_state()
    with pytest.raises(InputError, match=message):
        plant.step(forces)  # type: ignore[arg-type]
    assert np.array_equal(plant.get_state(), before)


@pytest.mark.parametrize("q", [[np.nan, 0.0], [0.0, np.inf]])
def test_initial_state_that_is_not_finite_is_rejected(q: list[float]) -> None:
    with pytest.raises(InputError, match="not finite"):
        Plant(planar_2r()).reset(q)


def test_invalid_robot_is_rejected() -> None:
    robot = planar_2r()
    bad = replace(robot, links=robot.links[:1])
    with pytest.raises(RobotError):
        Plant(bad)


def skeleton_of(plant: Plant) -> Skeleton:
    mechanism = plant._mechanism
    assert isinstance(mechanism, DartMechanism)
    return mechanism.skeleton


def test_loads_on_task_points_equal_dart_forces() -> None:
    """Compare J_p'w with a force that DART applies at the point, in world axes."""
    robot = random_robot(11, joints=5, muscles=4)
    frames = (
        TaskFrame("tip", "link_4", (0.1, -0.2, 0.3), ("y",)),
        TaskFrame("turn", "link_3", axes=("alpha",)),
        TaskFrame("knee", "link_2", (0.3, 0.1, 0.0)),
    )
    robot = replace(robot, task_sets=(TaskSet("points", frames),), task_set="points")
    pushed, reference = Plant(robot), Plant(robot, engine="dart")
    skeleton = skeleton_of(reference)
    f, w = np.full(4, 3.0), np.array([1.0, -2.0, 3.0, -4.0, 5.0, -6.0])
    for _ in range(50):
        pushed.step(f, loads=w)
        for frame, force in (("tip", w[:3]), ("knee", w[3:])):
            point = next(p for p in frames if p.name == frame)
            body = skeleton.bodies[point.link]
            body.addExtForce(force, np.array(point.position), False, True)
        reference.step(f)
    np.testing.assert_allclose(pushed.q, reference.q, rtol=0, atol=1e-12)
    with pytest.raises(InputError, match=r"loads must have shape \(6,\)"):
        pushed.step(f, loads=[1.0])
    with pytest.raises(InputError, match="loads must be finite"):
        pushed.step(f, loads=np.full(6, np.nan))
