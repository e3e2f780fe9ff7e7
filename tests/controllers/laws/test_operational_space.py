from __future__ import annotations

import numpy as np
import pytest
import qpsolvers
from support.robots.arms import PointMass, TwoLinkArm

from addin_sdfusion.robot import InputError, SimulationError
from controllers import OperationalSpaceController, Posture
from controllers.laws.operational_space import TASK_WEIGHT

ZERO = np.zeros(2)


def redundant_arm() -> TwoLinkArm:
    """Return the arm with only the height of its tip as task, so that it is redundant."""

    class OneTask(TwoLinkArm):
        task_names = ("tip.z",)
        task_angles = np.zeros(1, dtype=bool)

        def task_position(self, q):
            return super().task_position(q)[1:]

        def task_jacobian(self, q):
            return super().task_jacobian(q)[1:]

        def task_bias(self, q, qd):
            return super().task_bias(q, qd)[1:]

    return OneTask()


def acceleration(arm, q, qd, forces, w_e=0.0):
    """Return the acceleration by forces, from the equation of motion."""
    torque = arm.muscle_jacobian(q).T @ forces + arm.coriolis(q, qd) + arm.gravity(q) + w_e
    return np.linalg.solve(arm.mass_matrix(q), -torque - arm.damping * qd)


def test_forces_produce_the_commanded_task_acceleration() -> None:
    """J qdd + J' qd = ydd_d + Kd (yd_d - J qd) + Kp (y_d - y), qdd by the equation of motion."""
    arm, kp, kd = TwoLinkArm(), np.array([100.0, 60.0]), np.array([20.0, 14.0])
    controller = OperationalSpaceController(arm, kp, kd)
    rng = np.random.default_rng(0)
    for _ in range(50):
        q = np.array([0.3, 1.2]) + rng.uniform(-0.3, 0.3, 2)
        qd, yd_d, ydd_d, w_e = rng.uniform(-0.5, 0.5, (4, 2))
        y_d = arm.task_position(q) + rng.uniform(-0.05, 0.05, 2)
        solution = controller.solve(q, qd, y_d, yd_d, ydd_d, w_e=w_e)
        assert solution.status == "solved"
        assert solution.bound_violation == 0.0
        J = arm.task_jacobian(q)
        desired = ydd_d + kd * (yd_d - J @ qd) + kp * (y_d - arm.task_position(q))
        qdd = acceleration(arm, q, qd, solution.forces, w_e)
        np.testing.assert_allclose(J @ qdd + arm.task_bias(q, qd), desired, atol=1e-6)
        np.testing.assert_allclose(solution.qdd, qdd, atol=1e-6)
        np.testing.assert_allclose(solution.slack, 0.0, atol=1e-6)
        assert solution.coordinate_names == ("tip.x", "tip.z")


@pytest.mark.parametrize("literal", [True, False])
def test_solution_minimises_the_cost_of_eq_4(literal: bool) -> None:
    """Compare it with the same program, formulated in NumPy and solved by another method."""
    arm, q0 = redundant_arm(), np.array([0.2, 0.4])
    posture = None if literal else Posture(kd=10.0, kp=25.0, q0=q0)
    H_q, H_f = np.array([1.0, 2.0]), np.array([1e-6, 2e-6, 3e-6, 4e-6])
    controller = OperationalSpaceController(
        arm,
        100.0,
        20.0,
        posture=posture,
        acceleration_weights=H_q,
        force_weights=H_f,
        pretension=0.0 if literal else 20.0,
    )
    rng = np.random.default_rng(1)
    for _ in range(20):
        q, qd = np.array([0.3, 1.2]) + rng.uniform(-0.3, 0.3, 2), rng.uniform(-1.0, 1.0, 2)
        y_d, zero = arm.task_position(q) + rng.uniform(-0.05, 0.05, 1), np.zeros(1)
        solution = controller.solve(q, qd, y_d, zero, zero)
        J, L, M = arm.task_jacobian(q), arm.muscle_jacobian(q), arm.mass_matrix(q)
        h = arm.coriolis(q, qd) + arm.gravity(q) + arm.damping * qd
        desired = -20.0 * J @ qd + 100.0 * (y_d - arm.task_position(q)) - arm.task_bias(q, qd)
        qdd_p = np.zeros(2) if literal else 25.0 * (q0 - q) - 10.0 * qd
        f_p = np.zeros(4) if literal else np.full(4, 20.0)
        expected = qpsolvers.solve_qp(
            np.diag(np.concatenate([H_q, H_f])),
            -np.concatenate([H_q * qdd_p, H_f * f_p]),
            A=np.block([[M, L.T], [J, np.zeros((1, 4))]]),
            b=np.concatenate([-h, desired]),
            lb=np.concatenate([np.full(2, -1e9), arm.f_min]),
            ub=np.concatenate([np.full(2, 1e9), arm.f_max]),
            solver="daqp",
        )
        np.testing.assert_allclose(solution.qdd, expected[:2], rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(solution.forces, expected[2:], rtol=1e-5, atol=1e-4)


def test_posture_moves_the_null_space() -> None:
    mass = PointMass()
    posture = Posture(kd=2.0, kp=4.0, q0=[0.0, 0.0, 1.0])
    controller = OperationalSpaceController(mass, 100.0, 20.0, posture=posture, force_weights=1e-9)
    qd = np.array([0.0, 0.0, 0.3])
    solution = controller.solve(np.zeros(3), qd, ZERO, ZERO, ZERO)
    np.testing.assert_allclose(solution.qdd, [0.0, 0.0, 4.0 - 0.6], atol=1e-6)


def test_form_of_the_paper_does_not_damp_self_motion() -> None:
    """Eq. (4) of the paper minimises the acceleration, so that self-motion continues."""
    controller = OperationalSpaceController(
        PointMass(), 100.0, 20.0, posture=None, force_weights=1e-9
    )
    qd = np.array([0.0, 0.0, 0.3])
    solution = controller.solve(np.zeros(3), qd, ZERO, ZERO, ZERO)
    np.testing.assert_allclose(solution.qdd, 0.0, atol=1e-6)


def test_infeasible_task_is_soft_and_named() -> None:
    """100 m/s² of 2 kg along x require 200 N. 50 N produce 24.5 m/s². The task y is feasible."""
    mass = PointMass()
    mass.f_max = np.full(6, 50.0)
    controller = OperationalSpaceController(mass, 1.0, 1.0)
    solution = controller.solve(np.zeros(3), np.zeros(3), ZERO, ZERO, np.array([100.0, 1.0]))
    assert solution.status == "soft"
    assert solution.bound_violation == 0.0
    np.testing.assert_allclose(solution.slack, [100.0 - 24.5, 0.0], atol=0.05)
    assert solution.at_max == ("+x",)
    assert "mass.x 75" in solution.describe()
    qdd = acceleration(mass, np.zeros(3), np.zeros(3), solution.forces)
    np.testing.assert_allclose(qdd, solution.qdd, atol=1e-6)


def test_error_of_a_weighted_task_matches_the_closed_form() -> None:
    """1/2 a² + W/2 (10 - a)² has its minimum at a = 10 W / (1 + W)."""
    controller = OperationalSpaceController(
        PointMass(),
        1.0,
        1.0,
        posture=Posture(kd=0.0),
        task_weights=[4.0, np.inf],
        force_weights=1e-12,
    )
    solution = controller.solve(np.zeros(3), np.zeros(3), ZERO, ZERO, np.array([10.0, 3.0]))
    np.testing.assert_allclose(solution.qdd[:2], [8.0, 3.0], atol=1e-6)
    assert solution.status == "solved"
    np.testing.assert_allclose(solution.slack, [2.0, 0.0], atol=1e-6)


class Conflicting(PointMass):
    """Point mass with two conflicting tasks and a third independent task."""

    task_names = ("first.x", "second.xy", "third.z")
    task_angles = np.zeros(3, dtype=bool)

    def task_position(self, q):
        return self.task_jacobian(q) @ q

    def task_jacobian(self, q):
        return np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])

    def task_bias(self, q, qd):
        return np.zeros(3)


@pytest.mark.parametrize("order", [(1, 2, 3), (2, 1, 3)])
def test_lower_priorities_are_met_as_far_as_higher_ones_allow(order) -> None:
    controller = OperationalSpaceController(Conflicting(), 1.0, 1.0, priorities=order)
    desired = np.array([3.0, -4.0, 2.0])
    solution = controller.solve(np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), desired)
    kept = desired[0] if order[0] == 1 else desired[1]
    assert solution.qdd[0] == pytest.approx(kept, abs=1e-6)
    assert solution.qdd[2] == pytest.approx(2.0, abs=1e-6)
    np.testing.assert_allclose(np.sort(np.abs(solution.slack)), [0.0, 0.0, 7.0], atol=1e-6)
    assert solution.status == "soft"


def test_equal_priorities_share_the_error() -> None:
    controller = OperationalSpaceController(Conflicting(), 1.0, 1.0)
    desired = np.array([3.0, -4.0, 2.0])
    solution = controller.solve(np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), desired)
    assert solution.qdd[0] == pytest.approx(-0.5, abs=1e-3)


@pytest.mark.slow
def test_joint_limits_are_approached_and_not_crossed() -> None:
    """The target is 0.3 m beyond the limit. The joint stops at the limit."""
    mass, T = PointMass(), 1e-3
    mass.q_max = np.array([0.2, np.inf, np.inf])
    controller = OperationalSpaceController(mass, 400.0, 40.0)
    q, qd, highest = np.zeros(3), np.zeros(3), 0.0
    for _ in range(3000):
        solution = controller.solve(q, qd, np.array([0.5, 0.0]), ZERO, ZERO)
        qd = qd + T * solution.qdd
        q = q + T * qd
        highest = max(highest, q[0])
    assert highest <= 0.2 + 1e-6
    assert q[0] == pytest.approx(0.2, abs=1e-4)
    assert solution.status == "soft"
    assert not solution.limits_dropped


def test_infeasible_joint_limit_is_reported() -> None:
    mass = PointMass()
    mass.q_max, mass.f_max = np.array([0.2, np.inf, np.inf]), np.full(6, 50.0)
    controller = OperationalSpaceController(mass, 400.0, 40.0)
    fast = np.array([100.0, 0.0, 0.0])
    solution = controller.solve(np.array([0.19, 0.0, 0.0]), fast, ZERO, ZERO, ZERO)
    assert solution.limits_dropped
    assert solution.status == "soft"
    assert solution.qdd[0] == pytest.approx(-24.5, abs=0.05)


def test_force_rate_weight_reduces_force_rates() -> None:
    """The change of forces between two ticks is reduced by the factor h/(h + w)."""
    mass = PointMass()
    slow = OperationalSpaceController(mass, 1.0, 1.0, force_weights=1e-3, force_rate_weights=3e-3)
    q, qd = np.zeros(3), np.zeros(3)
    forces = [slow.solve(q, qd, ZERO, ZERO, ZERO).forces for _ in range(2)]
    first, second = (f[:2] for f in forces)
    np.testing.assert_allclose(first, 1.0, atol=1e-6)
    np.testing.assert_allclose(second, first, atol=1e-6)
    pull = slow.solve(q, qd, ZERO, ZERO, np.array([50.0, 0.0])).forces
    free = OperationalSpaceController(mass, 1.0, 1.0, force_weights=1e-3)
    assert pull[1] - pull[0] == pytest.approx(100.0, abs=1e-5)
    back = slow.solve(q, qd, ZERO, ZERO, ZERO).forces
    assert back[1] == pytest.approx(0.75 * (pull[0] + pull[1]) / 2, rel=1e-5)
    assert free.solve(q, qd, ZERO, ZERO, ZERO).forces[1] == pytest.approx(1.0, abs=1e-6)


def test_pretension_tightens_antagonists() -> None:
    controller = OperationalSpaceController(PointMass(), 1.0, 1.0, pretension=30.0)
    forces = controller.solve(np.zeros(3), np.zeros(3), ZERO, ZERO, ZERO).forces
    np.testing.assert_allclose(forces[:4], 30.0, atol=1e-5)
    # No task acts along z. The mass sinks, since the cost trades acceleration for forces.
    np.testing.assert_allclose(forces[4:], 30.0 + np.array([-1, 1]) * 9.81, atol=1e-4)


def test_angle_errors_are_wrapped() -> None:
    mass = PointMass()
    mass.task_angles = np.array([True, False])
    controller = OperationalSpaceController(mass, 1.0, 1.0)
    error = controller.error(np.array([3.0, 3.0, 0.0]), np.array([-3.0, -3.0]))
    np.testing.assert_allclose(error, [2 * np.pi - 6.0, -6.0], atol=1e-12)


def test_restored_state_repeats_the_forces_bit_for_bit() -> None:
    controller = OperationalSpaceController(
        redundant_arm(), 100.0, 20.0, force_rate_weights=1e-6, solver="dual_newton"
    )
    rng, zero = np.random.default_rng(3), np.zeros(1)

    def forces(k: int) -> np.ndarray:
        q = np.array([0.3 + 0.01 * k, 1.2])
        return controller.solve(q, np.ones(2) * 0.1, np.ones(1), zero, zero).forces

    for k in range(5):
        forces(k)
    state = controller.get_state()
    expected = [forces(k) for k in range(5, 10)]
    for _ in range(3):
        forces(int(rng.integers(50)))
    controller.set_state(state)
    np.testing.assert_array_equal([forces(k) for k in range(5, 10)], expected)
    with pytest.raises(InputError, match="finite numbers"):
        controller.set_state(state[:-1])


def test_problem_is_built_without_solving_it() -> None:
    controller = OperationalSpaceController(PointMass(), 1.0, 1.0)
    problem = controller.build_problem(np.zeros(3), np.zeros(3), ZERO, ZERO, ZERO)
    assert problem.A.shape == (3 + 2, 3 + 6)
    np.testing.assert_allclose(problem.b, [0.0, 0.0, -2 * 9.81, 0.0, 0.0])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"kp": [1.0, 2.0, 3.0]}, "kp must be a number or 2 numbers"),
        ({"kp": 0.0}, "kp of 'mass.x' must be finite and above 0: 0.0"),
        ({"kp": [[1.0, 0.0], [0.0, -1.0]]}, "kp must be a number or 2 numbers"),
        ({"kd": -1.0}, "kd of 'mass.x' must be finite and not negative: -1.0"),
        ({"task_weights": [1.0, 0.0]}, "task_weights of 'mass.y' must be above 0: 0.0"),
        ({"force_weights": -1.0}, "force_weights of '-x' must be finite and above 0: -1.0"),
        ({"force_rate_weights": [1.0]}, None),
        ({"force_rate_weights": np.nan}, "force_rate_weights of '-x'"),
        ({"acceleration_weights": 0.0}, "acceleration_weights of 'x'"),
        ({"pretension": -1.0}, "pretension of '-x'"),
        (
            {"priorities": [1]},
            "priorities must be 2 finite numbers of at least 1, for mass.x, mass.y",
        ),
        ({"priorities": [0, 1]}, "priorities must be 2 finite numbers"),
        ({"limit_bandwidth": 0.0}, "limit_bandwidth must be positive"),
        ({"posture": Posture(kp=1.0)}, "a posture with a positive kp requires q0"),
        ({"posture": Posture(q0=[1.0])}, "posture q0 must be 3 finite numbers"),
        ({"solver": "dual_newtn"}, "no QP solver 'dual_newtn'; did you mean 'dual_newton'"),
    ],
)
def test_wrong_settings_raise_an_error_with_the_name(settings, message) -> None:
    arguments = {"kp": 1.0, "kd": 1.0} | settings
    if message is None:
        OperationalSpaceController(PointMass(), **arguments)
        return
    with pytest.raises(InputError, match=message):
        OperationalSpaceController(PointMass(), **arguments)


def test_inconsistent_force_limits_raise_an_error_with_the_name() -> None:
    controller = OperationalSpaceController(PointMass(), 1.0, 1.0)
    with pytest.raises(InputError, match=r"muscle '\+x': f_min 5.0 is above f_max 4.0"):
        controller.set_bounds(1.0, [10.0, 4.0, 10.0, 10.0, 10.0, 10.0]) or controller.set_bounds(
            5.0, [10.0, 4.0, 10.0, 10.0, 10.0, 10.0]
        )


def test_robot_without_tasks_raises_an_error() -> None:
    mass = PointMass()
    mass.task_names, mass.task_angles = (), np.zeros(0, dtype=bool)
    with pytest.raises(InputError, match="no operational space"):
        OperationalSpaceController(mass, 1.0, 1.0)


def test_values_that_are_not_finite_raise_an_error() -> None:
    controller = OperationalSpaceController(PointMass(), 1.0, 1.0)
    with pytest.raises(SimulationError, match="not finite"):
        controller.solve(np.zeros(3), np.zeros(3), np.array([np.nan, 0.0]), ZERO, ZERO)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({0: np.zeros(2)}, r"q has shape \(2,\), not \(3,\): x, y, z"),
        ({1: np.zeros(4)}, r"qd has shape \(4,\)"),
        ({2: np.zeros(3)}, r"y_d has shape \(3,\), not \(2,\): mass.x, mass.y"),
        ({4: np.zeros((2, 1))}, r"ydd_d has shape \(2, 1\)"),
    ],
)
def test_vectors_of_wrong_length_raise_an_error_with_the_name(changes, message) -> None:
    controller = OperationalSpaceController(PointMass(), 1.0, 1.0)
    vectors = [np.zeros(3), np.zeros(3), ZERO, ZERO, ZERO]
    for place, vector in changes.items():
        vectors[place] = vector
    with pytest.raises(InputError, match=message):
        controller.solve(*vectors)


def test_task_in_the_cost_is_always_feasible() -> None:
    """1/2 a² + alpha/2 (10 - a)² has its minimum at a = 10 alpha / (1 + alpha)."""
    mass = PointMass()
    controller = OperationalSpaceController(
        mass, 1.0, 1.0, task_weights=100.0, posture=Posture(kd=0.0), force_weights=1e-12
    )
    desired = np.array([10.0, 0.0])
    solution = controller.solve(np.zeros(3), np.zeros(3), ZERO, ZERO, desired)
    assert solution.qdd[0] == pytest.approx(1000.0 / 101.0, abs=1e-6)
    assert solution.status == "solved"
    mass.f_max = np.full(6, 15.0)
    weak = OperationalSpaceController(mass, 1.0, 1.0, task_weights=TASK_WEIGHT)
    solution = weak.solve(np.zeros(3), np.zeros(3), ZERO, ZERO, desired)
    assert solution.status == "solved"
    assert solution.qdd[0] == pytest.approx(7.0, abs=1e-6)
    assert solution.slack[0] == pytest.approx(3.0, abs=1e-6)
