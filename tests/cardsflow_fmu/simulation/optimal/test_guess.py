"""First guesses of motions of muscles with activations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.robots import EXAMPLES
from support.third_party_models import REACH

from cardsflow_fmu.simulation.optimal.guess import motion_from_start
from cardsflow_fmu.simulation.optimal.optimise import load_for_motion, optimise
from cardsflow_fmu.simulation.optimal.problem import MotionProblem, motion_problem

MOTION = {"motion.goals": [{"y": [0.5, -0.12]}], "motion.duration": 0.3, "motion.muscles": "laws"}


def hill_arm_problem(**settings: Any) -> MotionProblem:
    own = {f"motion.{key}": value for key, value in settings.items()}
    return motion_problem(load_for_motion(EXAMPLES / "hill_arm", MOTION | own))


def test_motion_with_the_commands_of_the_start_has_no_gaps() -> None:
    problem = hill_arm_problem(start_command=0.3)
    at = motion_from_start(problem)
    intervals = problem.problem.run(at, derivatives=False)
    assert intervals is not None
    np.testing.assert_allclose(intervals.ends, at.x[1:], rtol=1e-13, atol=1e-13)
    assert abs(at.x[-1] - at.x[0])[:2].max() > 0.1
    np.testing.assert_array_equal(at.u, problem.guess.u)


def test_without_motion_or_beyond_the_bounds_it_is_the_rest() -> None:
    still = hill_arm_problem()
    assert motion_from_start(still) is still.guess
    slow = hill_arm_problem(start_command=0.3, bounds={"qd_max": 0.1})
    assert motion_from_start(slow) is slow.guess


def test_reach_costs_as_much_as_in_moco_from_the_same_motion(shared: Path, tmp_path: Path) -> None:
    """OpenSim Moco 4.6 finds 0.4168 from our motion, which swings back; 0.5187 from its guess."""
    model = shared / "reference/moco/P3.osim"
    (tmp_path / "P3.osim").write_bytes(model.read_bytes())
    (tmp_path / "experiment.toml").write_text(REACH)
    motion = optimise(load_for_motion(tmp_path / "experiment.toml"))
    assert motion.solution.status == "optimal"
    assert motion.solution.cost == pytest.approx(0.4168, rel=0.03)
    assert motion.columns["q.r_shoulder_elev"].min() < -0.5
