"""Controllers of random robots in C: every law, norm and rank, with motors and loops."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.experiments import write_experiment
from support.robots.loops import random_loops
from support.robots.random_robots import random_state, random_tree

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.model.loop import LoopType
from cardsflow_fmu import Experiment
from cardsflow_fmu.models.by_role import C_MODELS, missing_in_c

KINDS: tuple[LoopType, ...] = ("revolute", "ball")

IN_JOINT_SPACE: list[dict[str, Any]] = [
    *({"type": law} for law in ("joint_space", "lyapunov", "force_position", "torque_position")),
    *({"type": "joint_space", "norm": norm} for norm in (1, 3, "infinity")),
    {"type": "joint_space", "observer": 20.0, "ki": 1.0, "delay": 1},
]
ON_TASKS: list[dict[str, Any]] = [
    {"type": "operational_space"},
    {"type": "reactive_qp"},
    {"type": "operational_space", "priorities": [1, 1, 1, 2, 2, 3], "observer": 20.0},
]


def robot_of(seed: int) -> tuple[Robot, list[float]]:
    """Return a random tree; a third have loops, and every second coordinate has a motor."""
    robot, q = (random_tree(seed), None) if seed % 3 else random_loops(seed, KINDS)
    joints = tuple(
        replace(
            joint,
            coordinates=tuple(
                replace(c, actuated=(seed + k) % 2 == 0, tau_min=-50.0, tau_max=50.0)
                for k, c in enumerate(joint.coordinates)
            ),
        )
        for joint in robot.joints
    )
    robot = replace(robot, joints=joints)
    at = random_state(robot, np.random.default_rng(seed))[0] if q is None else q
    return robot, at.tolist()


def experiment_of(folder: Path, seed: int, settings: dict[str, Any]) -> Experiment:
    robot, q = robot_of(seed)
    on_tasks = settings in ON_TASKS
    at = f"y = {[0.1] * 6}" if on_tasks else f"q = {q}"
    text = f"""[reference]
spline = "quintic"
points = [{{ time = 0.0, {at} }}, {{ time = 1.0, {at} }}]
[start]
q = {q}
[controller]
kp = 10.0
kd = 5.0
[run]
step = 0.001
duration = 0.01
"""
    laws = {f"controller.{k}": v for k, v in settings.items()}
    return Experiment.load(write_experiment(robot, folder, text), laws)


@pytest.mark.parametrize("settings", [*IN_JOINT_SPACE, *ON_TASKS], ids=str)
def test_ten_random_robots_run_in_c(settings: dict[str, Any], tmp_path: Path) -> None:
    for seed in range(10):
        if seed % 3 == 0 and settings["type"] in ("lyapunov", "torque_position"):
            continue  # laws without support for loops
        folder = tmp_path / str(seed)
        folder.mkdir()
        experiment = experiment_of(folder, seed, settings)
        for name in experiment.roles:
            assert missing_in_c(experiment, name) is None
            model = C_MODELS[name](experiment)
            model.initialize()
            if settings not in ON_TASKS:  # the tasks of these robots may be infeasible
                model.step(0.0, 1e-3)
            assert np.isfinite(model.outputs).all()
