"""`controller.passive`: joints that only their spring and damper move, in all engines."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.experiments import write_experiment
from support.robots.one_link import cable, one_link
from support.run_modes import RUN_MODES

from addin_sdfusion.robot import (
    Coordinate,
    Inertia,
    InputError,
    Joint,
    Link,
    Robot,
    revolute,
)
from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.run import simulate
from controllers import JointSpaceController
from sim_dart import CoreDynamics

Y = (0.0, 1.0, 0.0)
BODY = Inertia(1.0, (0.2, 0.0, 0.0), 0.01, 0.01, 0.01)

MOTION = """
[reference]
spline = "quintic"
[[reference.points]]
time = 0.0
q.q = 0.0
[[reference.points]]
time = 0.5
q.q = 0.3
[controller]
kp = 400.0
kd = 40.0
passive.wrist = true
[run]
step = 0.001
"""


def arm() -> Robot:
    """Return an arm: two cables move a link, the wrist at its end has a spring and a damper."""
    strands = [
        replace(cable(root, (0.3, 0.0, 0.0), f_max=1000.0), name=name)
        for name, root in (("up", (-0.1, 0.0, 0.5)), ("down", (-0.1, 0.0, -0.5)))
    ]
    robot = one_link(BODY, strands, motions=revolute(Y), lower=-1.0, upper=1.0)
    sprung = Coordinate("wrist", initial=0.1, damping=0.05, stiffness=4.0)
    wrist = Joint("wrist", "a", "hand", revolute(Y), (sprung,))
    return replace(robot, links=(*robot.links, Link("hand", BODY)), joints=(*robot.joints, wrist))


def experiment(folder: Path, **settings: Any) -> Experiment:
    return Experiment.load(write_experiment(arm(), folder, MOTION), settings)


def test_forces_produce_the_acceleration_of_the_driven_joint() -> None:
    """M qdd + C + G + D qd = -L'f is solved for qdd; the passive acceleration is arbitrary."""
    dynamics = CoreDynamics(arm())
    law = JointSpaceController(dynamics, 100.0, 20.0, passive=[False, True])
    rng = np.random.default_rng(1)
    for _ in range(20):
        q, qd, q_d, qd_d, qdd_d = rng.uniform(-0.5, 0.5, (5, 2))
        solution = law.solve(q, qd, q_d, qd_d, qdd_d)
        assert solution.status == "solved"
        torque = (
            dynamics.coriolis(q, qd) + dynamics.gravity(q) + dynamics.damping * qd
            + dynamics.muscle_jacobian(q).T @ solution.forces
        )  # fmt: skip
        qdd = -np.linalg.solve(dynamics.mass_matrix(q), torque)
        commanded = qdd_d + 20.0 * (qd_d - qd) + 100.0 * (q_d - q)
        np.testing.assert_allclose(qdd[0], commanded[0], rtol=1e-9, atol=1e-9)
        assert solution.slack[1] == 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("through", "engine"), [("direct", "dart"), ("native", "auto"), ("fmu", "auto")]
)
def test_driven_joint_tracks_while_the_passive_joint_swings(
    through: str, engine: str, tmp_path: Path
) -> None:
    found = experiment(tmp_path, **{"plant.engine": engine, "controller.engine": engine})
    result = simulate(found, **RUN_MODES[through])
    summary = result.summary
    assert summary["infeasible_ticks"] == 0
    assert list(summary["tracking"]["per_signal"]) == ["q.q"]
    assert summary["tracking"]["max"] < 2e-3
    assert np.ptp(result["q.wrist"]) > 0.05
    other = simulate(experiment(tmp_path), coupling="direct")
    np.testing.assert_allclose(result["q.wrist"], other["q.wrist"], atol=2e-4)


def test_invalid_passive_coordinate_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"passive: requires .* 'joint_space' .*, not 'lyapunov'"):
        experiment(tmp_path, **{"controller.type": "lyapunov"})
    with pytest.raises(
        InputError, match=r"controller\.passive: at least one coordinate must not be passive"
    ):
        experiment(tmp_path, **{"controller.passive.q": True})
