from __future__ import annotations

import numpy as np
import pytest
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError
from controllers.laws.lyapunov import LyapunovController
from sim_dart import DartDynamics, Plant

ZERO = np.zeros(2)


def test_forces_equal_weight_spring_and_damper() -> None:
    """As CASPR's: its inverse dynamics at rest, with Kp e + Kd e' as the external load."""
    dynamics = DartDynamics(planar_2r())
    kp, kd = np.array([15.0, 10.0]), np.array([2.0, 1.0])
    controller = LyapunovController(dynamics, kp, kd)
    load = np.array([0.5, -0.2])
    for q, qd, q_d, qd_d, qdd_d in np.random.default_rng(1).uniform(-0.3, 0.3, (20, 5, 2)):
        L = dynamics.muscle_jacobian(q)
        solution = controller.solve(q, qd, q_d, qd_d, qdd_d)
        assert solution.status == "solved"
        tau = dynamics.gravity(q) + kp * (q_d - q) + kd * (qd_d - qd)
        np.testing.assert_allclose(-L.T @ solution.forces, tau, atol=1e-6)
        loaded = controller.solve(q, qd, q_d, qd_d, qdd_d, w_e=load, correction=load)
        np.testing.assert_allclose(-L.T @ loaded.forces, tau + 2 * load, atol=1e-6)


def test_energy_only_falls_and_the_robot_comes_to_rest_at_the_reference() -> None:
    """V = 1/2 qd'M qd + 1/2 e'Kp e, V' = -qd'(Kd + D) qd, though M is in no equation of the law."""
    dynamics, plant = DartDynamics(planar_2r()), Plant(planar_2r())
    kp, kd, q_d = np.array([20.0, 2.0]), np.array([4.0, 0.4]), np.array([0.1, -0.1])
    controller = LyapunovController(dynamics, kp, kd)
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


def test_wrong_gains_are_refused() -> None:
    with pytest.raises(InputError, match="kp of 'joint_2'"):
        LyapunovController(DartDynamics(planar_2r()), [1.0, -1.0], 1.0)
