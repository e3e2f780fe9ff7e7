"""`controller.norm` and `controller.pretension`: selection among the feasible forces."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.simulation.run import simulate
from controllers.force_distribution.methods import distribute
from sim_dart import CoreDynamics


def experiment(**controller: Any) -> Experiment:
    settings = {f"controller.{key}": value for key, value in controller.items()}
    short = {"run.duration": 0.04, "muscles.*.f_min": 1.0}
    return Experiment.load(EXAMPLES / "planar_2r", short | settings)


@pytest.mark.parametrize("norm", [1, 2, 4, "infinity"])
def test_forces_of_a_run_minimise_the_norm(norm: Any) -> None:
    """At each state, no other forces with the same torque are nearer to the pretension."""
    own = experiment(norm=norm, pretension=30.0)
    result = simulate(own, coupling="direct")
    robot, p = CoreDynamics(own.robot), own.controller.norm
    q = np.column_stack([result[f"q.{name}"] for name in robot.coordinate_names])
    f = np.column_stack([result[f"f.{name}"] for name in robot.muscle_names])
    L = np.array([robot.muscle_jacobian(state) for state in q])
    torque = -np.einsum("pmn,pm->pn", L, f)
    best = distribute(L, torque, robot.f_min, robot.f_max, "p_norm", p=p, target=30.0).forces
    np.testing.assert_allclose(
        np.linalg.norm(f - 30.0, p, axis=1), np.linalg.norm(best - 30.0, p, axis=1), rtol=1e-9
    )


def test_written_norm_is_read_back_unchanged() -> None:
    for norm in (1.0, 4.0, "infinity"):
        assert experiment_data(experiment(norm=norm))["controller"]["norm"] == norm
