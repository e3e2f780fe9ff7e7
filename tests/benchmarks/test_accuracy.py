"""Measurement of accuracy: `pytest tests/benchmarks/test_accuracy.py -s`.

Each value is the largest difference found. docs/explanation/accuracy.md contains these values.
"""

from __future__ import annotations

import numpy as np
import pytest
from support.interleaved import record
from support.oracles.mujoco_model import MujocoRobot
from support.robots.robots import EXAMPLES, chain, planar_2r

from addin_sdfusion.robot import Robot, read_robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.run import simulate
from controllers import ForceDistribution
from sim_dart import CoreDynamics, DartDynamics, MusclePaths, Plant

POSES = 200


def left_arm() -> Robot:
    return read_robot(EXAMPLES / "roboy_left_arm/robot")


ROBOTS = {"arm, 11 muscles on 4 joints": left_arm(), "chain, 60 muscles on 20 joints": chain()}
each_robot = pytest.mark.parametrize("name", ROBOTS)


def largest_difference(first: np.ndarray, second: np.ndarray) -> float:
    return float(np.abs(np.asarray(first) - np.asarray(second)).max())


@each_robot
def test_muscles_and_dynamics_match_mujoco(name: str) -> None:
    robot = ROBOTS[name]
    rival, paths = MujocoRobot(robot), MusclePaths(robot)
    engines = {"core": CoreDynamics(robot), "dart": DartDynamics(robot)}
    rng, n = np.random.default_rng(0), len(robot.coordinates)
    worst = dict.fromkeys(("l_m", "L_m", "core_M", "core_bias", "dart_M", "dart_bias"), 0.0)
    for _ in range(POSES):
        q, qd = rng.uniform(-1, 1, (2, n))
        rival.move(q, qd)
        state = paths.evaluate(q)
        found = {
            "l_m": largest_difference(state.lengths, rival.lengths),
            "L_m": largest_difference(state.jacobian, rival.jacobian),
        }
        for engine, dynamics in engines.items():
            bias = dynamics.coriolis(q, qd) + dynamics.gravity(q)
            size = max(np.abs(bias).max(), 1.0)
            found[f"{engine}_M"] = largest_difference(dynamics.mass_matrix(q), rival.mass_matrix)
            found[f"{engine}_bias"] = largest_difference(bias, rival.bias) / size
        worst = {key: max(value, found[key]) for key, value in worst.items()}
    record(f"against MuJoCo, {name}", **worst)
    assert max(worst.values()) <= 1e-11


@pytest.mark.parametrize("example", ["roboy_left_arm", "hill_arm"])
def test_moment_arms_are_the_derivative_of_the_lengths(example: str) -> None:
    robot = read_robot(EXAMPLES / example / "robot")
    paths, h, worst = MusclePaths(robot), 1e-6, 0.0
    low, high = np.array([(c.lower, c.upper) for c in robot.coordinates]).clip(-3.0, 3.0).T
    for q in np.random.default_rng(0).uniform(low, high, (POSES, len(low))):
        L = paths.evaluate(q).jacobian.copy()
        for j, e in enumerate(h * np.eye(len(low))):
            slope = paths.evaluate(q + e).lengths.copy()
            slope -= paths.evaluate(q - e).lengths
            worst = max(worst, largest_difference(L[:, j], slope / (2 * h)))
    record(f"moment arms against central differences, {example}", L_m=worst)
    assert worst <= 1e-6


def test_forces_produce_the_desired_torque() -> None:
    dynamics = DartDynamics(left_arm())
    distribution = ForceDistribution(dynamics.f_min, dynamics.f_max)
    worst, solved, rng = 0.0, 0, np.random.default_rng(0)
    for _ in range(POSES):
        q = np.array([1.45, 0.0, 0.0, -1.0]) + rng.uniform(-0.3, 0.3, 4)
        tau = dynamics.gravity(q) + rng.uniform(-5, 5, 4)
        solution = distribution.solve(dynamics.muscle_jacobian(q), tau)
        assert solution.bound_violation == 0.0
        if solution.status == "solved":
            solved, worst = solved + 1, max(worst, solution.equality_residual)
    record("force distribution, arm", torque_error_Nm=worst, solved=float(solved))
    assert solved > POSES / 2
    assert worst <= 1e-6


@pytest.mark.parametrize(("integrator", "order"), [("euler", 1), ("rk4", 4)])
def test_order_of_the_integrators(integrator: str, order: int) -> None:
    """Compute the order from runs with full, half and quarter steps, away from joint limits."""
    robot = planar_2r()

    def end(step: float) -> np.ndarray:
        plant = Plant(robot, step, integrator=integrator)
        plant.reset(np.array([0.05, -0.05]), np.zeros(2))
        for _ in range(round(0.1 / step)):
            plant.step(np.full(4, 10.0))
        return plant.q.copy()

    coarse, middle, fine = (end(2e-3 / 2**k) for k in range(3))
    found = float(np.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine)))
    record(f"order of {integrator}", order=found)
    assert found == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize("example", ["planar_2r", "roboy_left_arm"])
def test_tracking_of_the_examples(example: str) -> None:
    result = simulate(Experiment.load(EXAMPLES / example), compute="python", coupling="direct")
    tracking = result.summary["tracking"]
    record(
        f"tracking, {example}",
        rms=tracking["rms"],
        max=tracking["max"],
        unit=tracking["unit"],
        infeasible_ticks=float(result.summary["infeasible_ticks"]),
    )
    assert tracking["rms"] < 1e-4
