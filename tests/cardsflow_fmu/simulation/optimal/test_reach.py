"""Reach of Roboy's left arm: convergence, and the hand's error when a run follows the motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.optimal.files import write_motion_files
from cardsflow_fmu.simulation.optimal.optimise import OptimisedMotion, load_for_motion, optimise
from cardsflow_fmu.simulation.run import simulate
from sim_dart import CoreDynamics

pytestmark = pytest.mark.slow

ARM = EXAMPLES / "roboy_left_arm"
GOAL = [0.35, -0.45, 0.55]
LAW = {"controller": {"type": "trajectory_feedback"}}


@pytest.fixture(scope="module")
def motion() -> OptimisedMotion:
    own = {"motion.duration": 1.0, "motion.intervals": 100, "motion.goals": [{"y": GOAL}]}
    return optimise(load_for_motion(ARM, own))


def test_cost_is_within_1_percent_after_8_iterations(motion: OptimisedMotion) -> None:
    history = motion.solution.history
    assert motion.solution.status == "optimal"
    costs = [progress.cost for progress in history]
    assert all(abs(cost / costs[-1] - 1.0) < 0.01 for cost in costs[8:])
    assert history[8].violation < 1e-3
    y = [motion.columns[f"y.hand.{axis}"][-1] for axis in "xyz"]
    np.testing.assert_allclose(y, GOAL, atol=1e-6)


@pytest.mark.parametrize(("masses", "limit"), [(1.0, 1e-3), (1.1, 5e-3)])
def test_hand_follows_the_motion(
    motion: OptimisedMotion, tmp_path: Path, masses: float, limit: float
) -> None:
    file, *_ = write_motion_files(motion, tmp_path / "motion.csv")
    reference = {"reference": {"type": "optimised", "file": str(file)}}
    experiment = Experiment.load(
        ARM, {**reference, **LAW, "run.coupling": "direct", "plant.mass_scale": masses}
    )
    result, dynamics = simulate(experiment), CoreDynamics(experiment.robot)
    names = [c.name for c in experiment.robot.coordinates]
    poses = zip(*(result.columns([f"{p}.{name}" for name in names]) for p in ("q", "q_d")))  # noqa: B905
    errors = [dynamics.task_position(q) - dynamics.task_position(q_d) for q, q_d in poses]
    assert np.linalg.norm(errors, axis=1).max() < limit
