"""Compare each law with the equation of the paper, formulated in NumPy and solved independently."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import qpsolvers
from scipy.optimize import linprog, lsq_linear
from support.robots.random_robots import random_robot
from support.robots.robots import EXAMPLES, planar_2r

from addin_sdfusion.robot import Robot, TaskSet
from cardsflow_fmu import Experiment
from controllers import JointSpaceController, OperationalSpaceController, Posture
from controllers.arrays import FloatArray
from controllers.dynamics import Dynamics, bias_torque
from controllers.laws import loop_in_c
from controllers.qp import solver
from controllers.qp.law_in_c import FAILED, SOFT, SOLVED, WRONG, LawInC, library
from sim_dart import CoreDynamics, DartDynamics

pytestmark = pytest.mark.native

KP, KD = 100.0, 20.0
TIGHT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}


def eq_3(robot: Dynamics, q: FloatArray, qd: FloatArray, reference: FloatArray) -> FloatArray:
    """Return the torque that the muscles must produce."""
    q_d, qd_d, qdd_d = reference
    a = qdd_d + KD * (qd_d - qd) + KP * (q_d - q)
    return robot.mass_matrix(q) @ a + bias_torque(robot, q, qd)


@pytest.mark.parametrize("seed", range(8))
def test_joint_space_matches_eq_3(seed: int) -> None:
    """Compare with quadprog, or with bounded least squares of M^-1 (tau + L'f) if infeasible."""
    robot = DartDynamics(random_robot(seed, joints=3, muscles=12))
    f_p, H = np.linspace(0.0, 10.0 * (seed % 3), robot.m), np.linspace(1.0, 2.0, robot.m)
    law = JointSpaceController(robot, KP, KD, pretension=f_p, weights=H)
    rng, seen = np.random.default_rng(seed), set()
    for _ in range(30):
        q, qd = rng.uniform(-1, 1, (2, 3))
        reference = rng.uniform(-1, 1, (3, 3)) * rng.choice([0.3, 3.0])
        tau, L = eq_3(robot, q, qd, reference), robot.muscle_jacobian(q)
        solution = law.solve(q, qd, *reference)
        expected = qpsolvers.solve_qp(
            np.diag(H), -H * f_p, A=-L.T, b=tau, lb=robot.f_min, ub=robot.f_max, solver="daqp"
        )
        assert solution.status == ("soft" if expected is None else "solved")
        if expected is None:
            M = robot.mass_matrix(q)
            rows, goal = np.linalg.solve(M, L.T), -np.linalg.solve(M, tau)
            closest = lsq_linear(rows, goal, (robot.f_min, robot.f_max), method="bvls")
            missing = np.linalg.norm(np.linalg.solve(M, solution.slack))
            assert missing == pytest.approx(np.sqrt(2.0 * closest.cost), rel=1e-5)
        else:
            scale = np.abs(expected).max()
            np.testing.assert_allclose(solution.forces, expected, rtol=0, atol=1e-8 * scale)
        seen.add(solution.status)
    assert "solved" in seen


def min_norm(
    p: float, A: FloatArray, b: FloatArray, bounds: FloatArray, c: FloatArray, f_p: FloatArray
) -> float:
    """Solve min |c (f - f_p)|_p for p = 1 or infinity by HiGHS: min sum t, c |f - f_p| <= t."""
    m = A.shape[1]
    shares = np.eye(m) if p == 1 else np.ones((m, 1))
    k = shares.shape[1]
    answer = linprog(
        np.r_[np.zeros(m), np.ones(k)],
        A_ub=np.block([[np.diag(c), -shares], [-np.diag(c), -shares]]),
        b_ub=np.r_[c * f_p, -c * f_p],
        A_eq=np.c_[A, np.zeros((len(b), k))],
        b_eq=b,
        bounds=[*bounds.T.tolist(), *[(0.0, None)] * k],
        options=TIGHT,
    )
    assert answer.status == 0
    return float(answer.fun)


@pytest.mark.parametrize("p", [1.0, np.inf])
def test_norms_1_and_infinity_match_linear_programs(p: float) -> None:
    """Problems include muscles, motors, weights and pretensions; forces may be at their limits."""
    rng = np.random.default_rng(0)
    for _ in range(200):
        n = int(rng.integers(1, 6))
        m = n + int(rng.integers(1, 8))
        law, L = LawInC(n, m), rng.normal(size=(m, n)) * 10.0 ** rng.uniform(-2, 0)
        low = rng.uniform(0, 10, m) - (np.arange(m) == m - 1) * 40.0
        high = low + rng.uniform(1, 300, m)
        f = np.where(rng.random(m) < 0.3, low, rng.uniform(low, high))
        H, f_p = 10.0 ** rng.uniform(-2, 2, m), rng.uniform(0, 40, m) * rng.integers(0, 2)
        law.write(law=-1, L=L, tau=-L.T @ f, M=np.eye(n), norm=p, H_f=H, f_p=f_p)
        law.write(f_min=low, f_max=high)
        assert law.solve() == SOLVED
        found = np.linalg.norm(np.sqrt(H) * (law["forces"] - f_p), p)
        best = min_norm(p, -L.T, -L.T @ f, np.array([low, high]), np.sqrt(H), f_p)
        assert found == pytest.approx(best, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("p", [1.0, np.inf])
def test_solution_nearest_to_the_pretension_is_returned(p: float) -> None:
    """Two equal muscles share a torque if only the sum is minimised."""
    law = LawInC(1, 3)
    law.write(law=-1, L=[[-0.1], [-0.1], [0.1]], tau=4.0, M=1.0, norm=p, H_f=1.0, f_p=5.0)
    law.write(f_min=0.0, f_max=100.0)
    assert law.solve() == SOLVED
    assert law["forces"][:2] == pytest.approx(law["forces"][:1].repeat(2))
    best = {1.0: 35.0, np.inf: 15.0}[p]
    assert np.linalg.norm(law["forces"] - 5.0, p) == pytest.approx(best, rel=1e-9)
    assert law["forces"][2] == pytest.approx(0.0, abs=1e-6)


def lexicographic(rows: list[FloatArray], goals: list[FloatArray], low, high) -> list[float]:
    """Return the minimum |rows f - goal| by priority, from bounded least squares."""
    errors, higher_rows, values = [], np.empty((0, len(low))), np.empty(0)
    for J, c in zip(rows, goals, strict=True):
        heavy = np.vstack([1e4 * higher_rows, J])
        solution = lsq_linear(heavy, np.r_[1e4 * values, c], (low, high), method="bvls", tol=1e-14)
        errors.append(float(np.linalg.norm(J @ solution.x - c)))
        higher_rows, values = np.vstack([higher_rows, J]), np.r_[values, J @ solution.x]
    return errors


def test_lower_priority_does_not_affect_a_higher_one(arm: DartDynamics) -> None:
    """The tip height of the arm has priority 1. Errors match the lexicographic minimum."""
    law = OperationalSpaceController(
        arm, KP, KD, priorities=[2, 1], posture=Posture(kd=1.0), limit_bandwidth=None
    )
    rng, soft_ticks = np.random.default_rng(4), 0
    for _ in range(60):
        q = rng.uniform(-np.pi, np.pi, 2)
        qd, zero = rng.uniform(-0.3, 0.3, 2), np.zeros(2)
        y_d = arm.task_position(q) + rng.uniform(-0.3, 0.3, 2) * rng.choice([0.03, 1.0])
        solution = law.solve(q, qd, y_d, zero, zero)
        h = np.c_[bias_torque(arm, q, qd), arm.muscle_jacobian(q).T]
        response = -np.linalg.solve(arm.mass_matrix(q), h)  # qdd = a + B f
        J = arm.task_jacobian(q)
        desired = KP * (y_d - arm.task_position(q)) - KD * J @ qd - arm.task_bias(q, qd)
        rows, goal = J @ response[:, 1:], desired - J @ response[:, 0]
        order = [[1], [0]]
        goals = [goal[i] for i in order]
        minimum = lexicographic([rows[i] for i in order], goals, arm.f_min, arm.f_max)
        tolerance = 0.01 * np.linalg.norm(solution.qdd) + 1e-3
        assert abs(solution.slack[1]) <= minimum[0] + tolerance
        if minimum[0] < 1e-9:
            assert abs(solution.slack[1]) < 1e-6
        soft_ticks += solution.status == "soft"
    assert 5 < soft_ticks < 60


def planar() -> tuple[Robot, FloatArray]:
    return planar_2r(), np.array([0.1, -0.2])


def roboy() -> tuple[Robot, FloatArray]:
    arm = Experiment.load(EXAMPLES / "roboy_left_arm")
    return arm.robot, np.array(arm.start.q)


TOLERANCES = {"osqp": 1e-4, "daqp": 1e-6, "quadprog": 1e-6, "proxqp": 1e-5}
"""Force tolerances relative to the largest force. OSQP and ProxQP stop at residuals of 1e-9."""


@pytest.mark.parametrize("name", TOLERANCES)
@pytest.mark.parametrize("robot", [planar, roboy])
def test_other_back_ends_solve_the_arms(
    name: str, robot: Callable[[], tuple[Robot, FloatArray]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A back end solves the exported program with the same forces, without a fallback."""
    if name not in solver.available_solvers():
        pytest.skip(f"{name} is not installed: extra qp")
    described, q = robot()
    dynamics, answers = DartDynamics(described), []
    solve = solver.solve
    monkeypatch.setattr(solver, "solve", lambda p, s: answers.append(solve(p, s)) or answers[-1])
    rest, y = np.zeros(dynamics.n), dynamics.task_position(q).copy()
    still = np.zeros(len(y))
    for kind, position, other in (
        (JointSpaceController, q + 0.01, rest),
        (OperationalSpaceController, y + 0.002, still),
    ):
        expected = kind(dynamics, KP, KD).solve(q, rest, position, other, other)
        assert expected.status == "solved"
        law = kind(dynamics, KP, KD)
        law.solver = name
        found = law.solve(q, rest, position, other, other)
        assert found.status == "solved"
        near = TOLERANCES[name] * np.abs(expected.forces).max()
        np.testing.assert_allclose(found.forces, expected.forces, rtol=0, atol=near)
        problem = law.build_problem(q, rest, position, other, other)
        assert isinstance(problem, qpsolvers.Problem)
        x = solve(problem, name)
        forces = x if kind is JointSpaceController else x[dynamics.n :]
        np.testing.assert_allclose(forces[: dynamics.m], expected.forces, rtol=0, atol=near)
    assert len(answers) == 2
    assert all(answer is not None for answer in answers)


def test_wrong_numbers_are_rejected_without_changing_forces() -> None:
    robot, law = DartDynamics(planar_2r()), LawInC(2, 4)
    law.write(kp=1.0, kd=1.0, H_f=1.0, f_min=robot.f_min, f_max=robot.f_max)
    law.reset()
    zero = np.zeros(2)
    terms = {
        "M": robot.mass_matrix(zero),
        "h": bias_torque(robot, zero, zero),
        "L": robot.muscle_jacobian(zero),
        "error": zero,
    }
    law.write(**terms)
    assert law.solve() in (SOLVED, SOFT)
    forces = law["forces"].copy()
    for name in terms:
        law.write(**terms)
        law.write(**{name: np.nan})
        assert law.solve() in (WRONG, FAILED)
        assert np.array_equal(law["forces"], forces)


def test_sizes_are_checked() -> None:
    size = library().computed_torque_size
    assert size(2, 4, 0) > 0
    for wrong in ((0, 4, 0), (2, 0, 0), (2, 4, -1), (5000, 4, 0), (2, 5000, 0)):
        assert size(*wrong) == 0


def hand_only(seed: int) -> Robot:
    """Return a random robot with a single end-effector point."""
    robot = random_robot(seed, joints=4, muscles=14)
    return replace(robot, task_sets=(TaskSet("hand", robot.task_frames[:1]),), task_set="hand")


@pytest.mark.parametrize("seed", range(4, 8))
def test_redundant_task_rows_are_not_disturbed(seed: int) -> None:
    """Rows of priority 2 do not change the error of six rows of priority 1."""
    robot = random_robot(seed, joints=4)
    hand, elbow, palm = robot.task_frames
    q, missed = np.full(4, 0.1), []
    for frames in ((hand, palm), (hand, palm, elbow)):
        dynamics = CoreDynamics(
            replace(robot, task_sets=(TaskSet("some", frames),), task_set="some")
        )
        k = len(dynamics.task_names)
        ranks = [1.0] * 6 + [2.0] * (k - 6)
        law = OperationalSpaceController(dynamics, KP, KD, priorities=ranks)
        missed.append(law.solve(q, 0 * q, np.full(k, 0.1), np.zeros(k), np.zeros(k)).slack[:6])
    np.testing.assert_allclose(missed[1], missed[0], rtol=0, atol=1e-6 * np.abs(missed[0]).max())


@pytest.mark.parametrize("weight", [np.inf, 10.0])
@pytest.mark.parametrize("seed", range(4))
def test_operational_space_matches_eq_4(seed: int, weight: float) -> None:
    """DAQP solves eq. (4) over [qdd, f, s], with posture, pretension, force rates and limits."""
    robot, rng = DartDynamics(hand_only(seed)), np.random.default_rng(seed)
    n, m, k, w = robot.n, robot.m, len(robot.task_names), 20.0
    q0, f_last = np.full(n, 0.1), robot.f_min.copy()
    law = OperationalSpaceController(
        robot,
        KP,
        KD,
        posture=Posture(kd=5.0, kp=30.0, q0=q0),
        task_weights=weight,
        force_weights=1e-3,
        force_rate_weights=1e-4,
        pretension=6.0,
        limit_bandwidth=w,
    )
    solved, S = 0, np.eye(k) if np.isfinite(weight) else np.empty((k, 0))
    for _ in range(15):
        q, qd = rng.uniform(-0.3, 0.3, (2, n))
        y, J = robot.task_position(q).copy(), robot.task_jacobian(q).copy()
        y_d, yd_d, ydd_d = np.array([y, J @ qd, np.zeros(k)]) + rng.uniform(-0.01, 0.01, (3, k))
        found = law.solve(q, qd, y_d, yd_d, ydd_d)
        desired = ydd_d + KD * (yd_d - J @ qd) + KP * (y_d - y) - robot.task_bias(q, qd)
        qdd_p = 30.0 * (q0 - q) - 5.0 * qd
        free, brake = np.full(S.shape[1], np.inf), -2 * w * qd
        M, L = robot.mass_matrix(q), robot.muscle_jacobian(q)
        expected = qpsolvers.solve_qp(
            np.diag(np.r_[np.ones(n), np.full(m, 1.1e-3), np.full(S.shape[1], weight)]),
            np.r_[-qdd_p, np.full(m, -6e-3) - 1e-4 * f_last, np.zeros(S.shape[1])],
            A=np.block([[M, L.T, np.zeros((n, S.shape[1]))], [J, np.zeros((k, m)), S]]),
            b=np.r_[-bias_torque(robot, q, qd), desired],
            lb=np.r_[brake - w * w * (q - robot.q_min), robot.f_min, -free],
            ub=np.r_[brake + w * w * (robot.q_max - q), robot.f_max, free],
            solver="daqp",
        )
        assert (found.status == "solved") == (expected is not None)
        f_last = found.forces
        if expected is not None:
            scale = np.abs(expected[n : n + m]).max()
            np.testing.assert_allclose(found.forces, expected[n : n + m], rtol=0, atol=1e-6 * scale)
            solved += 1
    assert solved > 3 or not np.isfinite(weight)


def test_loop_in_c_distributes_the_torque_of_a_callback() -> None:
    """The callback computes PD+ control with load and correction at the measured state."""
    robot = DartDynamics(planar_2r())

    class PdPlus(JointSpaceController):
        def required_torque(self, q, qd, q_d, qd_d, qdd_d, *, w_e=None, correction=None):
            known = robot.mass_matrix(q) @ qdd_d + bias_torque(robot, q, qd)
            return known + 20.0 * (q_d - q) + 2.0 * (qd_d - qd) + w_e + correction

    law = PdPlus(robot, 1.0, 1.0)

    callbacks, P = loop_in_c.Callbacks(), ctypes.c_void_p
    view, read = callbacks.view, callbacks.read

    def compute(q, qd, reference, correction, load, tau):
        state = read(q, 2), read(qd, 2), *read(reference, 6).reshape(3, 2)
        loads = {"w_e": read(load, 2), "correction": read(correction, 2)}
        view(tau, 2)[:] = law.required_torque(*state, **loads)
        return 0

    torque = ctypes.CFUNCTYPE(ctypes.c_int, *[P] * 7)(callbacks.guard(compute, 1))
    structure = loop_in_c.LawStructure(torque=ctypes.cast(torque, P))
    loop = loop_in_c.LoopInC(robot, 2, callbacks, structure)
    loop.write(H_f=1.0, f_min=robot.f_min, f_max=robot.f_max)
    rng = np.random.default_rng(0)
    for q, qd, *reference, load in rng.uniform(-0.1, 0.1, (20, 6, 2)):
        loop.tick(1e-3, q, qd, np.array(reference), load)
        expected = law.solve(q, qd, *reference, w_e=load, correction=np.zeros(2))
        np.testing.assert_allclose(loop["acting"], expected.forces, atol=1e-9)
