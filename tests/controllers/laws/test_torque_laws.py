"""Tests of laws with a formula for the joint torque: torque position, force position, Lyapunov."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError, SimulationError
from controllers import ControlLoop, JointSpaceController
from controllers.arrays import FloatArray
from controllers.dynamics import bias_torque
from sim_dart import DartDynamics, Plant

ZERO = np.zeros(2)
KP, KD = np.array([15.0, 10.0]), np.array([2.0, 1.0])
Formula = Callable[..., FloatArray]


def lyapunov(d: DartDynamics, q: FloatArray, qd: FloatArray, e: FloatArray, ed: FloatArray):
    return d.gravity(q) + KP * e + KD * ed


def force_position(d: DartDynamics, q: FloatArray, qd: FloatArray, e: FloatArray, ed: FloatArray):
    return d.mass_matrix(q) @ (KP * e + KD * ed) + bias_torque(d, q, qd)


def torque_position(d: DartDynamics, q: FloatArray, qd: FloatArray, e: FloatArray, ed: FloatArray):
    return KP * e - KD * qd


LAWS = {
    "lyapunov": lyapunov,
    "force_position": force_position,
    "torque_position": torque_position,
}


@pytest.mark.parametrize(("law", "formula"), LAWS.items())
def test_forces_produce_the_torque_of_the_formula(law: str, formula: Formula) -> None:
    """The load and the correction of the torque, or of the acceleration, are included."""
    dynamics = DartDynamics(planar_2r())
    controller, load = JointSpaceController(dynamics, KP, KD, law=law), np.array([0.5, -0.2])
    for q, qd, q_d, qd_d, qdd_d in np.random.default_rng(1).uniform(-0.3, 0.3, (20, 5, 2)):
        L, tau = dynamics.muscle_jacobian(q), formula(dynamics, q, qd, q_d - q, qd_d - qd)
        solution = controller.solve(q, qd, q_d, qd_d, qdd_d)
        assert solution.status == "solved"
        np.testing.assert_allclose(-L.T @ solution.forces, tau, atol=1e-6)
        loaded = controller.solve(q, qd, q_d, qd_d, qdd_d, w_e=load, correction=load)
        more = dynamics.mass_matrix(q) @ load if law == "force_position" else load
        np.testing.assert_allclose(-L.T @ loaded.forces, tau + load + more, atol=1e-6)


def test_force_position_equals_computed_torque_without_reference_acceleration() -> None:
    dynamics = DartDynamics(planar_2r())
    controller = JointSpaceController(dynamics, 100.0, 20.0, law="force_position")
    computed = JointSpaceController(dynamics, 100.0, 20.0)
    for q, qd, q_d, qd_d, qdd_d in np.random.default_rng(1).uniform(-0.3, 0.3, (20, 5, 2)):
        forces = controller.solve(q, qd, q_d, qd_d, qdd_d).forces
        np.testing.assert_allclose(forces, computed.solve(q, qd, q_d, qd_d, ZERO).forces, atol=1e-9)


def test_joints_sag_by_gravity_divided_by_stiffness() -> None:
    """At rest Kp (q_d - q) = G(q)."""
    dynamics, plant = DartDynamics(planar_2r()), Plant(planar_2r())
    q_d, kp, kd = np.array([0.1, -0.1]), np.array([20.0, 2.0]), np.array([4.0, 0.4])
    controller = JointSpaceController(dynamics, kp, kd, law="torque_position")
    plant.reset(q_d)
    for _ in range(3000):
        plant.step(controller.solve(plant.q, plant.qd, q_d, ZERO, ZERO).forces)
    assert np.abs(plant.qd).max() < 1e-5
    np.testing.assert_allclose(kp * (q_d - plant.q), dynamics.gravity(plant.q), atol=1e-3)
    assert np.abs(plant.q - q_d).max() > 1e-3


@pytest.mark.slow
def test_integral_action_removes_the_sag() -> None:
    """The gain ki of the control loop is in [N·m/(rad·s)] for this law."""
    plant, q_d = Plant(planar_2r()), np.array([0.1, -0.1])
    law = JointSpaceController(
        DartDynamics(planar_2r()), [20.0, 2.0], [4.0, 0.4], law="torque_position"
    )
    loop = ControlLoop(law, law.dynamics.coordinate_names, 1e-3, ki=[30.0, 3.0])
    plant.reset(q_d)
    reference = np.stack([q_d, ZERO, ZERO])
    for _ in range(8000):
        loop.tick(plant.q, plant.qd, reference)
        plant.step(loop.acting)
    assert np.abs(plant.q - q_d).max() < 1e-4


@pytest.mark.slow
def test_full_mass_matrix_decouples_the_joints() -> None:
    """With only M_jj, as in kindyn, a step of the shoulder disturbs the elbow."""
    dynamics, target = DartDynamics(planar_2r()), np.array([0.05, 0.0])
    controller = JointSpaceController(dynamics, 100.0, 20.0, law="force_position")

    def full(q: FloatArray, qd: FloatArray) -> FloatArray:
        return controller.solve(q, qd, target, ZERO, ZERO).forces

    def diagonal(q: FloatArray, qd: FloatArray) -> FloatArray:
        tau = np.diag(dynamics.mass_matrix(q)) * (100.0 * (target - q) - 20.0 * qd)
        tau = tau + dynamics.coriolis(q, qd) + dynamics.gravity(q)
        return controller.distribution.solve(dynamics.muscle_jacobian(q), tau).forces

    def largest_elbow(forces: Formula) -> float:
        plant, elbow = Plant(planar_2r()), 0.0
        plant.reset(ZERO)
        for _ in range(500):
            plant.step(forces(plant.q, plant.qd))
            elbow = max(elbow, abs(plant.q[1]))
        return elbow

    assert largest_elbow(full) < 1e-4
    assert largest_elbow(diagonal) > 20 * largest_elbow(full)


@pytest.mark.slow
def test_energy_decreases_and_the_robot_stops_at_the_reference() -> None:
    """V = 1/2 qd'M qd + 1/2 e'Kp e, V' = -qd'(Kd + D) qd, although the law does not use M."""
    dynamics, plant = DartDynamics(planar_2r()), Plant(planar_2r())
    kp, kd, q_d = np.array([20.0, 2.0]), np.array([4.0, 0.4]), np.array([0.1, -0.1])
    controller = JointSpaceController(dynamics, kp, kd, law="lyapunov")
    plant.reset(q_d + np.array([0.1, -0.05]))
    energies, losses = [], []
    for _ in range(3000):
        e, qd = q_d - plant.q, plant.qd
        energies.append(0.5 * qd @ dynamics.mass_matrix(plant.q) @ qd + 0.5 * kp @ e**2)
        losses.append(qd @ ((kd + dynamics.damping) * qd))
        solution = controller.solve(plant.q, qd, q_d, ZERO, ZERO)
        assert solution.status == "solved"
        plant.step(solution.forces)
    assert np.diff(energies).max() < 1e-3 * energies[0]
    lost = 1e-3 * np.cumsum(losses)[:-1]
    np.testing.assert_allclose(energies[0] - np.array(energies[1:]), lost, atol=0.05 * energies[0])
    np.testing.assert_allclose(plant.q, q_d, atol=1e-5)


@pytest.mark.parametrize("law", LAWS)
def test_wrong_input_raises_an_error(law: str) -> None:
    dynamics = DartDynamics(planar_2r())
    with pytest.raises(InputError, match="kp of 'joint_2'"):
        JointSpaceController(dynamics, [1.0, -1.0], 1.0, law=law)
    with pytest.raises(InputError, match="kd"):
        JointSpaceController(dynamics, 1.0, [1.0, 1.0, 1.0], law=law)
    controller = JointSpaceController(dynamics, 1.0, 1.0, law=law)
    with pytest.raises(SimulationError, match="not finite"):
        controller.solve(ZERO, ZERO, np.array([np.nan, 0.0]), ZERO, ZERO)
