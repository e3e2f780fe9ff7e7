"""Experiments to play with: a given one, or the first experiment of a robot."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from addin_sdfusion.robot.formats.read import holds_robot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.reader import EXPERIMENT_TOML

from .starter import init


def is_robot(path: str | Path) -> bool:
    """Return whether a path is a robot, and not an experiment."""
    path = Path(path)
    is_experiment = path.suffix == ".toml" or (path.is_dir() and (path / EXPERIMENT_TOML).is_file())
    return not is_experiment and holds_robot(path)


@contextlib.contextmanager
def playable(
    path: str | Path,
    settings: Mapping[str, Any] | None = None,
    note: Callable[[str], object] = print,
) -> Iterator[Experiment]:
    """Provide the experiment at a path, or one as from `cardsflow init` for a robot.

    Args:
        path: An experiment.toml, its folder, a robot file or its folder.
        settings: Changes by full key, such as `{"controller.period": 0.01}`.
        note: Called with each change that makes a robot movable.

    Raises:
        InputError: The experiment is invalid, or the muscles cannot move the robot.
        RobotError: The robot is invalid.
    """
    path = Path(path)
    if not is_robot(path):
        yield Experiment.load(path, settings)
        return
    with tempfile.TemporaryDirectory() as folder:
        # the experiment has the name of the folder of its robot
        name = path.resolve().name if path.is_dir() else path.resolve().parent.name
        starter = init(path, Path(folder, name or "robot", EXPERIMENT_TOML))
        for line in starter.notes:
            note(f"note: {line}")
        yield Experiment.load(starter.file, settings)
