"""Compare stiffness with finite differences of the muscle torque and measured values."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError, SimulationError, read_robot
from controllers.analysis.stiffness import stiffness, task_stiffness
from controllers.force_distribution.quadratic import least_squares
from sim_dart import DartDynamics


def elastic_torque(
    robot: DartDynamics, q: np.ndarray, at: np.ndarray, f: np.ndarray, k: float
) -> np.ndarray:
    """Return the joint torque at q of elastic muscles with forces f at another configuration."""
    stretch = robot.muscle_lengths(q) - robot.muscle_lengths(at)
    return -robot.muscle_jacobian(q).T @ (f + k * stretch) - robot.gravity(q)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("k", [0.0, 500.0])
def test_stiffness_is_the_derivative_of_the_torque(seed: int, k: float) -> None:
    robot = DartDynamics(random_robot(seed))
    rng = np.random.default_rng(seed)
    q, f = rng.uniform(-1, 1, robot.n), rng.uniform(10, 100, robot.m)
    found = stiffness(robot, q, f, muscle_stiffness=k)
    h, columns = 1e-5, []
    for e in np.eye(robot.n) * h:
        ahead, behind = (elastic_torque(robot, q + s * e, q, f, k) for s in (1, -1))
        columns.append((behind - ahead) / (2 * h))
    size = np.abs(found.total).max()
    np.testing.assert_allclose(found.total, np.array(columns).T, atol=1e-6 * size)
    np.testing.assert_array_equal(found.total, found.total.T)
    assert found.asymmetry < 1e-8 * size


@pytest.mark.parametrize("step", [3e-4, 3e-3])
def test_stiffness_does_not_depend_on_the_step(step: float) -> None:
    robot = DartDynamics(planar_2r())
    found = stiffness(robot, [0.3, -0.4], [50.0] * 4, step=step).geometric
    expected = stiffness(robot, [0.3, -0.4], [50.0] * 4).geometric
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8)


def test_cable_over_a_lever_matches_the_closed_form() -> None:
    """For the first joint of the arm, l = |a + R(q) b|."""
    robot = DartDynamics(planar_2r())
    q = np.array([0.4, 0.0])
    tail, head = (
        np.array([0.5, 0.0]),
        np.array([0.1, 0.8]),
    )  # ends of cable 1, in world coordinates at q = 0
    c, s = np.cos(0.4), np.sin(0.4)
    point = np.array([[c, s], [-s, c]]) @ head  # rotation about y
    length = np.linalg.norm(point - tail)
    turn = np.array([point[1], -point[0]])  # d point / dq
    slope = (point - tail) @ turn / length
    bend = (turn @ turn - (point - tail) @ point - slope**2) / length
    f = np.array([100.0, 0.0, 0.0, 0.0])
    assert robot.muscle_jacobian(q)[0, 0] == pytest.approx(slope)
    assert stiffness(robot, q, f).geometric[0, 0] == pytest.approx(100.0 * bend, rel=1e-9)


@pytest.mark.parametrize(
    ("q", "f_min", "rate"),
    [
        ([-0.5, 0.5], 0.0, 79),
        ([-0.5, 0.5], 10.0, 1759),
        ([-0.5, 0.5], 20.0, 3440),
        ([0.0, 0.0], 10.0, 2981),
    ],
)
def test_pretension_destabilises_the_two_link_arm(q: list[float], f_min: float, rate: int) -> None:
    """The rate, which a position gain must exceed, was measured by another implementation."""
    robot = DartDynamics(planar_2r())
    forces = least_squares(robot.muscle_jacobian(q), robot.gravity(q), f_min, 100.0).forces
    found = stiffness(robot, q, forces)
    assert found.rates(robot.mass_matrix(q))[-1] == pytest.approx(rate, abs=1.0)
    assert not found.is_stable
    assert any("the muscle forces destabilise" in text for text in found.warnings())
    with pytest.raises(
        SimulationError, match="the compliance does not exist: the configuration is unstable"
    ):
        found.compliance(robot.task_jacobian(q))


def test_elastic_muscles_stabilise_the_arm() -> None:
    robot, q = DartDynamics(planar_2r()), np.array([0.2, -0.3])
    forces = least_squares(robot.muscle_jacobian(q), robot.gravity(q), 10.0, 100.0).forces
    found = stiffness(robot, q, forces, muscle_stiffness=2000.0)
    assert found.is_stable
    assert [text for text in found.warnings() if "unstable" in text] == []
    assert found.rates(robot.mass_matrix(q))[-1] < 0


def test_task_compliance_matches_the_displacement_by_a_small_force() -> None:
    """Compare the equilibrium with a force at the tip, by Newton's method, with J K⁻¹ J'."""
    robot, q, k = DartDynamics(planar_2r()), np.array([0.2, -0.3]), 3000.0
    f = least_squares(robot.muscle_jacobian(q), robot.gravity(q), 10.0, 100.0).forces
    joint = stiffness(robot, q, f, muscle_stiffness=k)
    J = robot.task_jacobian(q)
    load, x = np.array([1e-3, -2e-3]), q.copy()
    for _ in range(30):
        x += np.linalg.solve(
            joint.total, elastic_torque(robot, x, q, f, k) + robot.task_jacobian(x).T @ load
        )
    moved = robot.task_position(x) - robot.task_position(q)
    np.testing.assert_allclose(joint.compliance(J) @ load, moved, rtol=1e-4)
    K = task_stiffness(robot, q, f, k)
    np.testing.assert_allclose(K @ joint.compliance(J), np.eye(2), atol=1e-9)
    with pytest.raises(InputError, match="linearly dependent"):
        joint.task_stiffness(np.vstack([J, J[:1]]))


def test_warnings_name_the_joints(shared: Path) -> None:
    robot = DartDynamics(read_robot(shared / "robots/caspr/RoboyLeftArm", "DEFAULT"))
    q = np.array([1.45, 0.0, 0.0, -1.3])
    f = least_squares(robot.muscle_jacobian(q), robot.gravity(q), robot.f_min, robot.f_max).forces
    found = stiffness(robot, q, f)
    assert found.asymmetry < 1e-9
    for text in found.warnings():
        assert any(name in text for name in robot.coordinate_names)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"q": [0.0]}, "q must be 2 finite numbers"),
        ({"forces": [1.0, 2.0, 3.0, np.nan]}, "forces must be 4 finite numbers"),
        ({"forces": "no"}, "forces must be 4 numbers"),
        ({"muscle_stiffness": -1.0}, "muscle_stiffness of 'cable_1'"),
        ({"step": 0.0}, "step must be finite and positive"),
    ],
)
def test_wrong_input_raises_an_error(change: dict[str, object], message: str) -> None:
    arguments: dict[str, object] = {"q": [0.0, 0.0], "forces": [10.0] * 4} | change
    with pytest.raises(InputError, match=message):
        stiffness(DartDynamics(planar_2r()), **arguments)  # type: ignore[arg-type]
    found = stiffness(DartDynamics(planar_2r()), [0.0, 0.0], [10.0] * 4)
    with pytest.raises(InputError, match=r"J must have shape \(k, 2\)"):
        found.compliance(np.ones((1, 3)))
