"""Experiments and robots in folders, and the files that FMUs contain."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import Robot, write_sdf
from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.writer import experiment_resources


def copy_arm(folder: Path, **files: str) -> Path:
    """Copy the two-link arm to `folder`/arm, with its experiment and further .py files."""
    shutil.copytree(PLANAR_2R / "robot", folder / "arm/robot")
    shutil.copy(PLANAR_2R / "experiment.toml", folder / "arm")
    for name, text in files.items():
        (folder / f"arm/{name}.py").write_text(text)
    return folder / "arm"


def write_experiment(robot: Robot, folder: Path, text: str = "") -> Path:
    """Write a robot and its experiment, with further settings as TOML, to a folder."""
    write_sdf(robot, folder / "robot")
    (folder / "experiment.toml").write_text(f'robot.path = "robot"\n{text}')
    return folder


def with_robot(example: str, robot: Robot, folder: Path, **changes: Any) -> Experiment:
    """Return the experiment of an example with another robot, which is written to a folder."""
    write_sdf(robot, folder)
    own = {"robot.path": str(folder / "model.sdf")}
    return Experiment.load(EXAMPLES / example, own | changes)


def twin_arms(folder: Path, apart: float, text: str = "") -> Experiment:
    """Write an experiment of 10 ms with two two-link arms, a and b."""
    arms = [("a", 0.0), ("b", apart)]
    robots = "".join(
        f"[[robots]]\nname = '{name}'\npath = '{PLANAR_2R / 'robot'}'\nposition = [{x}, 0, 0]\n"
        for name, x in arms
    )
    points = "".join(f"[[reference.points]]\ntime = {t}\nq = 0.3\n" for t in (0.0, 0.01))
    rest = f"[controller]\nkp = 100.0\nkd = 20.0\n[reference]\nspline = 'linear'\n{points}{text}"
    (folder / "experiment.toml").write_text(robots + rest)
    return Experiment.load(folder)


def resource_bytes(experiment: Experiment, **options: Any) -> dict[str, bytes]:
    """Return the content of the files of an experiment, by path."""
    return {
        place: content if isinstance(content, bytes) else content.read_bytes()
        for place, content in experiment_resources(experiment, **options).items()
    }


def write_resources(experiment: Experiment, folder: Path, **options: Any) -> Path:
    """Write the files of an experiment to a folder; return the folder."""
    for place, content in resource_bytes(experiment, **options).items():
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        (folder / place).write_bytes(content)
    return folder
