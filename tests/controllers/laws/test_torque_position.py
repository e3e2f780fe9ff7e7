from __future__ import annotations

import numpy as np
import pytest
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError, SimulationError
from controllers import ControlLoop, JointSpaceController
from controllers.laws.force_position import ForcePositionController
from controllers.laws.torque_position import TorquePositionController
from sim_dart import DartDynamics, Plant

ZERO = np.zeros(2)
STATES = np.random.default_rng(1).uniform(-0.3, 0.3, (20, 5, 2))


def torque(dynamics: DartDynamics, q: np.ndarray, forces: np.ndarray) -> np.ndarray:
    return -dynamics.muscle_jacobian(q).T @ forces


def test_forces_make_a_spring_and_a_damper() -> None:
    dynamics = DartDynamics(planar_2r())
    kp, kd = np.array([15.0, 10.0]), np.array([2.0, 1.0])
    controller = TorquePositionController(dynamics, kp, kd)
    load = np.array([0.5, -0.2])
    for q, qd, q_d, qd_d, qdd_d in STATES:
        solution = controller.solve(q, qd, q_d, qd_d, qdd_d)
        assert solution.status == "solved"
        tau = kp * (q_d - q) - kd * qd
        np.testing.assert_allclose(torque(dynamics, q, solution.forces), tau, atol=1e-6)
        loaded = controller.solve(q, qd, q_d, qd_d, qdd_d, w_e=load, correction=load)
        np.testing.assert_allclose(torque(dynamics, q, loaded.forces), tau + 2 * load, atol=1e-6)


def test_the_joints_sag_by_their_weight_over_the_spring() -> None:
    """At rest Kp (q_d - q) = G(q)."""
    dynamics, plant = DartDynamics(planar_2r()), Plant(planar_2r())
    q_d, kp, kd = np.array([0.1, -0.1]), np.array([20.0, 2.0]), np.array([4.0, 0.4])
    controller = TorquePositionController(dynamics, kp, kd)
    plant.reset(q_d)
    for _ in range(3000):
        plant.step(controller.solve(plant.q, plant.qd, q_d, ZERO, ZERO).forces)
    assert np.abs(plant.qd).max() < 1e-5
    np.testing.assert_allclose(kp * (q_d - plant.q), dynamics.gravity(plant.q), atol=1e-3)
    assert np.abs(plant.q - q_d).max() > 1e-3


def test_integral_action_lifts_the_weight() -> None:
    """The control loop's ki, here in [N·m/(rad·s)]."""
    plant, q_d = Plant(planar_2r()), np.array([0.1, -0.1])
    law = TorquePositionController(DartDynamics(planar_2r()), [20.0, 2.0], [4.0, 0.4])
    loop = ControlLoop(law, law.dynamics.coordinate_names, 1e-3, ki=[30.0, 3.0])
    plant.reset(q_d)
    reference = np.stack([q_d, ZERO, ZERO])
    for _ in range(8000):
        loop.tick(plant.q, plant.qd, reference)
        plant.step(loop.acting)
    assert np.abs(plant.q - q_d).max() < 1e-4


def test_force_position_is_computed_torque_of_a_reference_without_acceleration() -> None:
    dynamics = DartDynamics(planar_2r())
    controller = ForcePositionController(dynamics, 100.0, 20.0)
    computed = JointSpaceController(dynamics, 100.0, 20.0)
    for q, qd, q_d, qd_d, qdd_d in STATES:
        forces = controller.solve(q, qd, q_d, qd_d, qdd_d).forces
        np.testing.assert_allclose(forces, computed.solve(q, qd, q_d, qd_d, ZERO).forces, atol=1e-9)
        a = 20.0 * (qd_d - qd) + 100.0 * (q_d - q)
        tau = dynamics.mass_matrix(q) @ a + dynamics.coriolis(q, qd) + dynamics.gravity(q)
        tau = tau + dynamics.damping * qd
        np.testing.assert_allclose(torque(dynamics, q, forces), tau, atol=1e-6)


def test_the_full_mass_matrix_keeps_a_step_of_one_joint_from_the_other() -> None:
    """With M_jj alone, as in kindyn, the elbow is thrown off by the shoulder's step."""
    dynamics, target = DartDynamics(planar_2r()), np.array([0.05, 0.0])
    controller = ForcePositionController(dynamics, 100.0, 20.0)
    thrown = {}
    for name in ("full", "diagonal"):
        plant = Plant(planar_2r())
        plant.reset(ZERO)
        elbow = 0.0
        for _ in range(500):
            q, qd = plant.q, plant.qd
            if name == "full":
                forces = controller.solve(q, qd, target, ZERO, ZERO).forces
            else:
                a = 100.0 * (target - q) - 20.0 * qd
                tau = np.diag(dynamics.mass_matrix(q)) * a
                tau = tau + dynamics.coriolis(q, qd) + dynamics.gravity(q)
                L = dynamics.muscle_jacobian(q)
                forces = controller.distribution.solve(L, tau).forces
            plant.step(forces)
            elbow = max(elbow, abs(plant.q[1]))
        thrown[name] = elbow
    assert thrown["full"] < 1e-4
    assert thrown["diagonal"] > 20 * thrown["full"]


@pytest.mark.parametrize("kind", [TorquePositionController, ForcePositionController])
def test_wrong_input_is_refused(kind: type[JointSpaceController]) -> None:
    dynamics = DartDynamics(planar_2r())
    with pytest.raises(InputError, match="kp of 'joint_2'"):
        kind(dynamics, [1.0, -1.0], 1.0)
    with pytest.raises(InputError, match="kd"):
        kind(dynamics, 1.0, [1.0, 1.0, 1.0])
    with pytest.raises(SimulationError, match="not finite"):
        kind(dynamics, 1.0, 1.0).solve(ZERO, ZERO, np.array([np.nan, 0.0]), ZERO, ZERO)
