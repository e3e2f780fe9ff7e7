"""Experiments in folders: of robots that are written there, and the files that FMUs carry."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import Robot, write_sdf
from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.writer import experiment_resources


def copied_arm(folder: Path, **files: str) -> Path:
    """The two-link arm's experiment and robot in `folder`/arm, and further files, `name` as .py."""
    shutil.copytree(PLANAR_2R / "robot", folder / "arm/robot")
    shutil.copy(PLANAR_2R / "experiment.toml", folder / "arm")
    for name, text in files.items():
        (folder / f"arm/{name}.py").write_text(text)
    return folder / "arm"


def written(robot: Robot, folder: Path, text: str = "") -> Path:
    """A robot and an experiment of it, which the text in TOML says all else of, in a folder."""
    write_sdf(robot, folder / "robot")
    (folder / "experiment.toml").write_text(f'robot.path = "robot"\n{text}')
    return folder


def with_robot(example: str, robot: Robot, folder: Path, **changes: Any) -> Experiment:
    """An example's experiment with another robot, which is written into a folder."""
    write_sdf(robot, folder)
    own = {"robot.path": str(folder / "model.sdf")}
    return Experiment.load(EXAMPLES / example, own | changes)


def twin_arms(folder: Path, apart: float, text: str = "") -> Experiment:
    """Two of the two-link arm, a and b, for 10 ms, as a file in a folder."""
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
    """The content of the files that travel with an experiment, by their places."""
    return {
        place: content if isinstance(content, bytes) else content.read_bytes()
        for place, content in experiment_resources(experiment, **options).items()
    }


def write_resources(experiment: Experiment, folder: Path, **options: Any) -> Path:
    """Write the files that travel with an experiment into a folder, which is returned."""
    for place, content in resource_bytes(experiment, **options).items():
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        (folder / place).write_bytes(content)
    return folder
