"""Every law, norm, priority, loop, motor and estimator in C, for random robots."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
from support.cases import sample_cases
from support.experiments import write_experiment
from support.robots.loops import random_loops
from support.robots.random_robots import random_robot
from support.robots.robots import with_coordinates

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.model.loop import LoopType
from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.signals.ports import task_names
from cardsflow_fmu.models.by_role import C_MODELS
from cardsflow_fmu.models.native.opened_model import OpenedModel
from cardsflow_fmu.models.native_loop import native_loop
from cardsflow_fmu.simulation.build import build

SEEDS = range(10)
SEEDS_OF_LOOPS = (0, 1, 2, 3, 5, 6, 7, 8, 10, 11)
"""Without robots whose loops prevent any motion."""
TORQUES = {"controller.kp": 20.0, "controller.kd": 0.5}
HILL = {
    "kind": "hill_millard2012",
    "max_isometric_force": "f_max",
    "optimal_fibre_length": "0.7 path",
    "tendon_slack_length": "0.3 path",
}
PLANS: dict[str, dict[str, Any]] = {
    "joint_space": {},
    "force_position": {"controller.type": "force_position"},
    "torque_position": {"controller.type": "torque_position"} | TORQUES,
    "lyapunov": {"controller.type": "lyapunov"} | TORQUES,
    "operational_space": {"controller.type": "operational_space"},
    "reactive_qp": {"controller.type": "reactive_qp"},
    **{f"norm {p}": {"controller.norm": p} for p in (*range(1, 9), "infinity")},
    "priorities": {
        "controller.type": "operational_space",
        "controller.priorities": {"hand.x": 1, "hand.y": 2, "hand.z": 1, "elbow.x": 3},
    },
    "ranks of reactive_qp": {
        "controller.type": "reactive_qp",
        "controller.priorities": {"hand.x": 2, "hand.y": 1},
    },
    "control loop": {
        "controller.ki": 50.0,
        "controller.observer": 20.0,
        "controller.delay": 1,
    },
    "late forces": {"controller.delay": 1, "controller.predict": False},
    "closed loops": {},
    "closed loops and tasks": {"controller.type": "operational_space"},
    "motors": {},
    "motors and tasks": {"controller.type": "reactive_qp"},
    "muscle laws": {"muscles.*.model": HILL},
    "energies": {"plant.energy": True, "plant.integrator": "rk4"},
    "estimator": {"estimator": {}},
    "estimator and tasks": {"estimator": {}, "controller.type": "operational_space"},
}


ON_TASKS = ("operational_space", "reactive_qp")
SDF_LOOPS: tuple[LoopType, ...] = ("fixed", "revolute", "prismatic", "universal", "ball")


def random_experiment(plan: str, seed: int, folder: Path, **more: Any) -> Experiment:
    """Return three ticks of a random robot with a goal near its start."""
    settings = {"controller.kp": 100.0, "controller.kd": 20.0} | PLANS[plan]
    robot, q = random_robot(seed, joints=4), np.full(4, 0.1)
    if "closed loops" in plan:
        robot, q = random_loops(seed, SDF_LOOPS)
    robot = with_coordinates(robot, actuated="motors" in plan)
    start = {c.name: float(value) for c, value in zip(robot.coordinates, q, strict=True)}
    on_tasks = settings.get("controller.type") in ON_TASKS
    goal = {"y": dict.fromkeys(task_names(robot), 0.1)} if on_tasks else {"q": start}
    run = {
        "reference.points": [{"time": 0.0} | goal, {"time": 1.0} | goal],
        "start.q": start,
        "run.step": 1e-3,
        "run.duration": 3e-3,
    }
    return Experiment.load(write_experiment(robot, folder), run | settings | more)


def check_run(plan: str, seed: int, folder: Path) -> None:
    """Check that all models of the experiment run in C, for three ticks."""
    experiment = random_experiment(plan, seed, folder)
    for model in experiment.columns:
        assert isinstance(C_MODELS[model](experiment).opened, OpenedModel)
    recording = native_loop(experiment).run()
    assert recording.failure is None
    assert np.isfinite(recording.rows).all()


@pytest.mark.parametrize("plan", sample_cases(PLANS, 4))
def test_experiment_runs_in_c(plan: str, tmp_path: Path) -> None:
    for seed in SEEDS_OF_LOOPS if "closed loops" in plan else SEEDS:
        check_run(plan, seed, tmp_path / str(seed))


@pytest.mark.slow
@pytest.mark.parametrize("plan", PLANS)
def test_fmus_are_in_c(plan: str, tmp_path: Path) -> None:
    experiment = random_experiment(plan, 0, tmp_path / "robot")
    for name, file in build(experiment, tmp_path / "fmus", compute="c").items():
        with ZipFile(file) as archive:
            assert "resources/native.bin" in archive.namelist(), name


CUSTOM_LAW = """
from controllers import JointSpaceController


class Own(JointSpaceController):
    pass
"""
UNSUPPORTED: dict[str, tuple[dict[str, Any], str]] = {
    "DART's plant": ({"plant.engine": "dart"}, 'a native plant does not support the engine "dart"'),
    "DART's terms": (
        {"controller.engine": "dart"},
        'a native controller does not support the engine "dart"',
    ),
    "contacts": ({"world": {"ground": {}}}, "a native plant does not support worlds with contacts"),
    "another solver": (
        {"controller.solver": "daqp"},
        "a native controller does not support the QP solver 'daqp'",
    ),
    "a custom law": (
        {"controller.type": "own.py:Own", "controller.space": "joint"},
        "a native controller does not support .*own.py:Own",
    ),
}


@pytest.mark.parametrize("what", UNSUPPORTED)
def test_unsupported_settings_are_rejected_by_name(what: str, tmp_path: Path) -> None:
    settings, message = UNSUPPORTED[what]
    (tmp_path / "own.py").write_text(CUSTOM_LAW)
    experiment = random_experiment("joint_space", 0, tmp_path, **settings)
    with pytest.raises(InputError, match=message):
        build(experiment, tmp_path / "fmus", compute="c")
