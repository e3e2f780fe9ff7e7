from __future__ import annotations

import numpy as np
import pytest
from support.robots.arms import TwoLinkArm
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError
from controllers import JointSpaceController
from sim_dart import DartDynamics


def test_forces_produce_the_commanded_joint_acceleration() -> None:
    """M^-1 (-L'f - C - G - D qd) = qdd_d + Kd (qd_d - qd) + Kp (q_d - q), for any dynamics."""
    arm, kp, kd = TwoLinkArm(), np.array([100.0, 50.0]), np.array([20.0, 14.0])
    controller = JointSpaceController(arm, kp, kd)
    rng = np.random.default_rng(0)
    for _ in range(50):
        q, qd, q_d, qd_d, qdd_d = rng.uniform(-0.3, 0.3, (5, 2))
        solution = controller.solve(q, qd, q_d, qd_d, qdd_d)
        assert solution.status == "solved"
        tau = -arm.muscle_jacobian(q).T @ solution.forces
        tau = tau - arm.coriolis(q, qd) - arm.gravity(q) - arm.damping * qd
        desired = qdd_d + kd * (qd_d - qd) + kp * (q_d - q)
        np.testing.assert_allclose(np.linalg.solve(arm.mass_matrix(q), tau), desired, atol=1e-7)
        assert solution.coordinate_names == ("shoulder", "elbow")


def test_problem_equals_eq_3() -> None:
    dynamics = DartDynamics(planar_2r())
    controller = JointSpaceController(dynamics, 2000.0, 90.0)
    q, qd, q_d = np.array([0.2, -0.1]), np.array([0.5, 0.3]), np.array([0.21, -0.12])
    zero = np.zeros(2)
    problem = controller.build_problem(q, qd, q_d, zero, zero)
    M, C, G = dynamics.mass_matrix(q), dynamics.coriolis(q, qd), dynamics.gravity(q)
    np.testing.assert_allclose(problem.b, M @ (2000 * (q_d - q) - 90 * qd) + C + G, atol=1e-12)
    np.testing.assert_array_equal(problem.A, -dynamics.muscle_jacobian(q).T)
    np.testing.assert_array_equal(problem.P, np.eye(4))
    np.testing.assert_array_equal(problem.lb, np.full(4, 10.0))
    np.testing.assert_array_equal(problem.ub, np.full(4, 100.0))


def test_infeasible_torque_is_soft_and_names_the_joint() -> None:
    controller = JointSpaceController(DartDynamics(planar_2r()), 2000.0, 90.0)
    zero = np.zeros(2)
    solution = controller.solve(zero, zero, np.array([1.0, 0.0]), zero, zero)
    assert solution.status == "soft"
    assert solution.slack[0] > 1.0
    assert np.all(solution.forces >= 10.0)
    assert "joint_1" in solution.describe()


@pytest.mark.parametrize("kp", [-1.0, np.nan, [1.0, -2.0], [1.0, 2.0, 3.0], "x", None])
def test_wrong_gains_raise_an_error(kp: object) -> None:
    with pytest.raises(InputError, match="kp"):
        JointSpaceController(TwoLinkArm(), kp, 1.0)  # type: ignore[arg-type]
