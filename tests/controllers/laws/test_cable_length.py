from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.cases import sample_cases
from support.robots.robots import PLANAR_2R, planar_2r

from addin_sdfusion.robot import InputError, Robot, SimulationError
from addin_sdfusion.robot.formats.read import read_trajectory
from controllers import SplineReference
from controllers.laws.cable_length import CableLengthController
from controllers.laws.cable_velocity import CableVelocityController
from controllers.laws.motors import SpringMotors
from sim_dart import DartDynamics, Plant

REFERENCE = SplineReference(
    read_trajectory(PLANAR_2R / "robot/planar_2r_trajectories.xml", "simple_joint_motion")
)
Q, QD, QDD = np.array([0.2, -0.3]), np.array([0.4, -0.1]), np.array([1.0, 2.0])
ZERO = np.zeros(2)


def heavier(robot: Robot, factor: float) -> Robot:
    links = []
    for link in robot.links:
        i = link.inertia
        moments = {k: factor * getattr(i, k) for k in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")}
        links.append(replace(link, inertia=replace(i, mass=factor * i.mass, **moments)))
    return replace(robot, links=tuple(links))


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
    springs = motors(stiffness)
    controller = CableLengthController(DartDynamics(robot), springs, pretension=pretension)
    plant = Plant(heavier(robot, mass))
    plant.reset(REFERENCE.evaluate(0.0).q)
    errors = []
    for k in range(8000):
        point = REFERENCE.evaluate(k * 1e-3)
        if k % 2 == 0:
            set_points = controller.solve(plant.q, plant.qd, *point).set_points
        errors.append(plant.q - point.q)
        pull(plant, springs, set_points)
    return float(np.sqrt(np.mean(np.sum(np.square(errors), axis=1)))) * 1e3


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("stiffness", "sag"), sample_cases([(300.0, 108.0), (100.0, 372.0), (1000.0, 30.3)])
)
def test_feedforward_forces_replace_joint_sensors(stiffness: float, sag: float) -> None:
    """Errors with pretension match published ones; errors with f_ff do not depend on K."""
    assert blind_error(stiffness, pretension=10.0) == pytest.approx(sag, rel=0.01)
    assert blind_error(stiffness) < 0.6


@pytest.mark.slow
def test_wrong_mass_causes_an_error_proportional_to_the_compliance() -> None:
    """The error matches the published one for soft springs and is smaller for stiff springs."""
    assert blind_error(100.0, mass=1.1) == pytest.approx(13.1, rel=0.02)
    assert blind_error(1000.0, mass=1.1) < 0.65


def test_set_points_produce_the_torque_of_the_reference() -> None:
    """At the reference, the spring forces produce the acceleration of the reference."""
    dynamics = DartDynamics(planar_2r())
    springs = motors(500.0)
    solution = CableLengthController(dynamics, springs).solve(ZERO, ZERO, Q, QD, QDD)
    L = dynamics.muscle_jacobian(Q)
    f = springs.forces(dynamics.muscle_lengths(Q), L @ QD, solution.set_points)
    np.testing.assert_allclose(f, solution.forces, atol=1e-9)
    torque = dynamics.mass_matrix(Q) @ QDD + dynamics.coriolis(Q, QD) + dynamics.gravity(Q)
    np.testing.assert_allclose(-L.T @ f, torque + dynamics.damping * QD, atol=1e-6)
    assert solution.status == "solved"


def test_infeasible_motion_has_status_soft() -> None:
    controller = CableLengthController(DartDynamics(planar_2r()), motors(500.0))
    solution = controller.solve(Q, QD, Q, QD, np.array([1e4, 0.0]))
    assert solution.status == "soft"
    assert solution.slack[0] > 1.0


def test_motors_convert_set_points_to_angles() -> None:
    springs = SpringMotors(("a", "b"), [100.0, 200.0], spindle_radius=[0.01, 0.02])
    zero, l0 = np.array([1.0, 1.0]), np.array([0.99, 1.02])
    np.testing.assert_allclose(springs.angles(l0, zero), [1.0, -1.0])
    np.testing.assert_allclose(springs.speeds(np.array([-0.01, 0.02])), [1.0, -1.0])
    slack = springs.forces(np.array([0.9, 1.1]), np.zeros(2), np.ones(2))
    np.testing.assert_allclose(slack, [0.0, 20.0])


@pytest.mark.parametrize(
    "wrong", [{"stiffness": 0.0}, {"damping": -1.0}, {"spindle_radius": [1.0, 0.0]}]
)
def test_wrong_motors_raise_an_error(wrong: dict) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        SpringMotors(("a", "b"), **{"stiffness": 1.0, **wrong})


def test_wrong_settings_raise_an_error() -> None:
    dynamics = DartDynamics(planar_2r())
    with pytest.raises(InputError, match="motors"):
        CableLengthController(dynamics, SpringMotors(("a", "b"), 1.0))
    with pytest.raises(InputError, match="pretension of 'cable_1'"):
        CableLengthController(dynamics, motors(1.0), pretension=-1.0)
    with pytest.raises(InputError, match="kp"):
        CableVelocityController(dynamics, -1.0)
    with pytest.raises(InputError, match="kd"):
        CableVelocityController(dynamics, 1.0, [1.0, 2.0, 3.0])
    with pytest.raises(InputError, match="qdd_d has shape"):
        CableLengthController(dynamics, motors(1.0)).solve(Q, QD, Q, QD, np.zeros(3))
    with pytest.raises(InputError, match="q_d has shape"):
        CableVelocityController(dynamics, 1.0).solve(Q, QD, np.zeros(3), QD)
    with pytest.raises(SimulationError, match="not finite"):
        CableVelocityController(dynamics, 1.0).solve(Q, QD, np.array([np.nan, 0.0]), QD)


def test_rates_move_the_joints_as_commanded() -> None:
    """With inextensible cables, l' = l0', the error follows e' = -(Kp / (1 + Kd)) e."""
    dynamics = DartDynamics(planar_2r())
    controller = CableVelocityController(dynamics, 6.0, 0.5)
    q, q_d, qd, T = Q + 0.1, Q.copy(), ZERO, 1e-3
    for k in range(2000):
        rates = controller.solve(q, qd, q_d, QD).rates
        qd = np.linalg.lstsq(dynamics.muscle_jacobian(q), rates, rcond=None)[0]
        if k == 500:
            np.testing.assert_allclose(q - q_d, 0.1 * np.exp(-4.0 * 0.5), rtol=0.02)
        q, q_d = q + T * qd, q_d + T * QD
    assert np.abs(q - q_d).max() < 1e-3


def test_without_feedforward_the_law_of_kindyn_lags() -> None:
    dynamics = DartDynamics(planar_2r())
    L = dynamics.muscle_jacobian(Q)
    e, ed = np.array([0.1, -0.2]), np.array([0.3, 0.1])
    kindyn = CableVelocityController(dynamics, 100.0, 2.0, feedforward=False)
    rates = kindyn.solve(Q, QD, Q + e, QD + ed).rates
    expected = sum(L[:, j] * (2.0 * ed[j] + 100.0 * e[j]) for j in range(2))
    np.testing.assert_allclose(rates, expected, atol=1e-12)
    led = CableVelocityController(dynamics, 100.0, 2.0).solve(Q, QD, Q + e, QD + ed).rates
    np.testing.assert_allclose(led - rates, L @ (QD + ed), atol=1e-12)


@pytest.mark.slow
def test_integrated_rates_remove_the_sag_of_springs() -> None:
    """Springs with a constant pretension sag. With integrated rates the joints reach q_d."""
    dynamics = DartDynamics(planar_2r())
    springs, plant = motors(1000.0), Plant(planar_2r())
    q_d = REFERENCE.evaluate(0.0).q
    blind = CableLengthController(dynamics, springs, pretension=10.0)
    set_points = blind.solve(q_d, ZERO, q_d, ZERO, ZERO).set_points
    plant.reset(q_d)
    for _ in range(3000):
        pull(plant, springs, set_points)
    assert np.abs(plant.q - q_d).max() > 0.01
    controller = CableVelocityController(dynamics, 3.0)
    for _ in range(4000):
        set_points = set_points + 1e-3 * controller.solve(plant.q, plant.qd, q_d, ZERO).rates
        pull(plant, springs, set_points)
    assert np.abs(plant.q - q_d).max() < 1e-4
