"""Periodic motion of two legs on a crank: cost, closed loops, and wrong input."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.simulation.optimal.guess import smooth_guess
from cardsflow_fmu.simulation.optimal.loops import closing
from cardsflow_fmu.simulation.optimal.optimise import load_for_motion, optimise
from cardsflow_fmu.simulation.optimal.problem import motion_problem

BICYCLE = EXAMPLES / "bicycle"
TURN, HARMONICS, TIMES, POSES = 2.0 * np.pi, 8, 72, 90


def _reduced(experiment: Experiment) -> CubicSpline:
    """Return M, G, C / ω², damping and force arms of the crank, as functions of its angle."""
    loops = closing(experiment, experiment.robot)
    assert loops is not None
    q, rows = np.array(experiment.start.q), []
    for angle in np.arange(POSES) * TURN / POSES:
        q[0] = angle
        q = loops.closed(q)
        J = loops.loop_jacobian(q)
        qd = np.r_[1.0, np.linalg.lstsq(J[:, 1:], -J[:, 0], rcond=None)[0]]
        ahead, back = loops.coriolis(q, qd)[0], loops.coriolis(q, -qd)[0]
        terms = loops.mass_matrix(q)[0, 0], loops.gravity(q)[0], ahead + back, ahead - back
        factors = [1, 1, 0.5, 0.5, *[1] * loops.m]
        rows.append(np.r_[terms, -loops.actuator_jacobian(q)[:, 0]] * factors)
    return CubicSpline(np.linspace(0, TURN, POSES + 1), [*rows, rows[0]], bc_type="periodic")


def _least_cost(experiment: Experiment) -> float:
    """Return the least int f'f dt of one turn in 1 s, by harmonics of the crank's motion."""
    terms, t = _reduced(experiment), np.arange(TIMES) / TIMES
    low = np.array([m.f_min for m in experiment.robot.muscles])
    high = np.array([m.f_max for m in experiment.robot.muscles])
    w = TURN * np.arange(1, HARMONICS + 1)
    s, c = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
    angle, rate, second = np.hstack([s, c]), np.hstack([w * c, -w * s]), np.hstack([s, c])
    second = second * -np.tile(w * w, 2)

    def forces(arms: NDArray[np.float64], torque: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the smallest forces clip(μ arms) that have the torque, by bisection of μ."""
        least, most = np.full(len(torque), -1e5), np.full(len(torque), 1e5)
        for _ in range(60):
            middle = 0.5 * (least + most)
            found = np.clip(middle[:, None] * arms, low, high)
            less = (arms * found).sum(axis=1) < torque
            least, most = np.where(less, middle, least), np.where(less, most, middle)
        return found

    def cost(k: NDArray[np.float64]) -> float:
        omega = TURN + rate @ k
        at = terms(np.mod(TURN * t + angle @ k, TURN))
        torque = at[:, 0] * (second @ k) + at[:, 1] + at[:, 2] * omega**2 + at[:, 3] * omega
        return float((forces(at[:, 4:], torque) ** 2).sum() / TIMES)

    return float(minimize(cost, np.zeros(2 * HARMONICS), options={"gtol": 1.0}).fun)


@pytest.mark.slow
def test_pedalling_costs_as_much_as_the_best_motion_of_the_crank() -> None:
    """Within 1 %, with closed loops; the oracle has the crank as its only coordinate."""
    experiment = load_for_motion(BICYCLE, {"motion.intervals": 26, "motion.substeps": 2})
    motion = optimise(experiment)
    assert motion.solution.status == "optimal"
    assert motion.solution.cost == pytest.approx(_least_cost(experiment), rel=0.01)
    x, loops = motion.solution.iterate.x, closing(experiment, experiment.robot)
    assert loops is not None
    assert max(loops.remaining_gap(row[:5]) for row in x) < 1e-6
    np.testing.assert_allclose(x[-1], x[0] + TURN * np.eye(10)[0], atol=1e-6)


def test_guess_and_motion_to_a_goal_close_the_loops() -> None:
    """Files of robots write 3e15 rad for joints without limits."""
    settings = {"motion.goals": [{"q": {"crank": 0.4}}], "motion.duration": 0.5}
    settings |= {"motion.periodic": {}, "motion.intervals": 8, "motion.bounds.q_max": 3e15}
    experiment = load_for_motion(BICYCLE, settings)
    guess, loops = smooth_guess(motion_problem(experiment)), closing(experiment, experiment.robot)
    assert loops is not None
    motion = optimise(experiment)
    assert motion.solution.status == "optimal"
    for x in (guess.x, motion.solution.iterate.x):
        assert max(loops.remaining_gap(row[:5]) for row in x) < 1e-6
        assert x[-1, 0] == pytest.approx(0.4)
    assert abs(motion.solution.iterate.x[-1, 5:]).max() < 1e-6


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("motion.goals=[{q={knee_left=1.0}}]", "goals[0].q.knee_left: follows from the closed"),
        ("motion.start.free=['crank']", "start: does not support closed loops"),
    ],
)
def test_coordinates_of_loops_are_rejected(
    capsys: pytest.CaptureFixture[str], setting: str, message: str
) -> None:
    line = CommandLine(capsys).error_line("optimise", BICYCLE, "-q", "--set", setting)
    assert f"motion.{message}" in line


def test_feedback_along_a_motion_rejects_loops() -> None:
    """It would need gains of independent coordinates."""
    settings = {"controller": {"type": "trajectory_feedback"}}
    with pytest.raises(InputError, match="closed loops, not 'trajectory_feedback'"):
        Experiment.load(BICYCLE, settings | {"reference": {"type": "rest"}})
