"""Experiments in folders: copies of the two-link arm's, and the files that FMUs carry."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.writer import experiment_resources


def copied_arm(folder: Path, **files: str) -> Path:
    """The two-link arm's experiment and robot in `folder`/arm, and further files, `name` as .py."""
    shutil.copytree(PLANAR_2R / "robot", folder / "arm/robot")
    shutil.copy(PLANAR_2R / "experiment.toml", folder / "arm")
    for name, text in files.items():
        (folder / f"arm/{name}.py").write_text(text)
    return folder / "arm"


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
