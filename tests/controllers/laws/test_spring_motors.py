"""Compare motors with springs with published errors and with closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.cases import sample_cases
from support.robots.robots import PLANAR_2R, planar_2r

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.formats.read import read_trajectory
from controllers import JointSpaceController, SplineReference, SpringMotors
from sim_dart import CoreDynamics, Plant

REFERENCE = SplineReference(
    read_trajectory(PLANAR_2R / "robot/planar_2r_trajectories.xml", "simple_joint_motion")
)


def heavier(robot: Robot, factor: float) -> Robot:
    links = tuple(replace(link, inertia=link.inertia.scaled(factor)) for link in robot.links)
    return replace(robot, links=links)


def motors(stiffness: float) -> SpringMotors:
    names = tuple(muscle.name for muscle in planar_2r().muscles)
    return SpringMotors(names, stiffness, damping=0.02 * stiffness)


def pull(plant: Plant, springs: SpringMotors, set_points: np.ndarray) -> None:
    """Simulate 1 ms of a plant with elastic muscles and motors at rest."""
    rates = plant.muscle_jacobian @ plant.qd
    plant.step(springs.forces(plant.muscle_lengths, rates, set_points))


def blind_error(stiffness: float, *, pretension: float | None = None, mass: float = 1.0) -> float:
    """Return the RMS error in mrad without joint sensors, with set points at 500 Hz."""
    robot = planar_2r()
    springs, dynamics = motors(stiffness), CoreDynamics(robot)
    law = JointSpaceController(dynamics, 1.0, 0.0)
    plant = Plant(heavier(robot, mass))
    plant.reset(REFERENCE.evaluate(0.0).q)
    errors = []
    for k in range(8000):
        q, qd, qdd = REFERENCE.evaluate(k * 1e-3)
        if k % 2 == 0:
            forces = np.full(4, pretension) if pretension else law.solve(q, qd, q, qd, qdd).forces
            rates = dynamics.muscle_jacobian(q) @ qd
            set_points = springs.set_points(dynamics.muscle_lengths(q), rates, forces)
        errors.append(plant.q - q)
        pull(plant, springs, set_points)
    return float(np.sqrt(np.mean(np.sum(np.square(errors), axis=1)))) * 1e3


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("stiffness", "sag"), sample_cases([(300.0, 108.0), (100.0, 372.0), (1000.0, 30.3)])
)
def test_forces_at_the_reference_replace_joint_sensors(stiffness: float, sag: float) -> None:
    """Errors with pretension match published ones; with forces, they do not depend on K."""
    assert blind_error(stiffness, pretension=10.0) == pytest.approx(sag, rel=0.01)
    assert blind_error(stiffness) < 0.6


@pytest.mark.slow
def test_wrong_mass_causes_an_error_proportional_to_the_compliance() -> None:
    """The error matches the published one for soft springs and is smaller for stiff springs."""
    assert blind_error(100.0, mass=1.1) == pytest.approx(13.1, rel=0.02)
    assert blind_error(1000.0, mass=1.1) < 0.65


def test_motors_convert_set_points_to_angles() -> None:
    springs = SpringMotors(("a", "b"), [100.0, 200.0], spindle_radius=[0.01, 0.02])
    zero, l0 = np.array([1.0, 1.0]), np.array([0.99, 1.02])
    np.testing.assert_allclose(springs.angles(l0, zero), [1.0, -1.0])
    np.testing.assert_allclose(springs.speeds(np.array([-0.01, 0.02])), [1.0, -1.0])
    slack = springs.forces(np.array([0.9, 1.1]), np.zeros(2), np.ones(2))
    np.testing.assert_allclose(slack, [0.0, 20.0])


def test_set_points_produce_the_given_forces() -> None:
    springs, lengths = motors(500.0), np.array([1.0, 1.5, 0.8, 2.0])
    rates, forces = np.array([0.1, -0.2, 0.0, 0.3]), np.array([10.0, 50.0, 0.0, 200.0])
    set_points = springs.set_points(lengths, rates, forces)
    np.testing.assert_allclose(springs.forces(lengths, rates, set_points), forces, atol=1e-9)


@pytest.mark.parametrize(
    "wrong", [{"stiffness": 0.0}, {"damping": -1.0}, {"spindle_radius": [1.0, 0.0]}]
)
def test_wrong_motors_raise_an_error(wrong: dict) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        SpringMotors(("a", "b"), **{"stiffness": 1.0, **wrong})


@pytest.mark.slow
def test_rates_remove_the_sag_of_springs() -> None:
    """Springs with a constant pretension sag. With integrated rates the joints reach q_d."""
    dynamics, plant = CoreDynamics(planar_2r()), Plant(planar_2r())
    springs, q_d = motors(1000.0), REFERENCE.evaluate(0.0).q
    set_points = springs.set_points(dynamics.muscle_lengths(q_d), np.zeros(4), np.full(4, 10.0))
    plant.reset(q_d)
    for _ in range(3000):
        pull(plant, springs, set_points)
    assert np.abs(plant.q - q_d).max() > 0.01
    for _ in range(4000):
        rates = dynamics.muscle_jacobian(plant.q) @ (3.0 * (q_d - plant.q))
        set_points = set_points + 1e-3 * rates
        pull(plant, springs, set_points)
    assert np.abs(plant.q - q_d).max() < 1e-4
