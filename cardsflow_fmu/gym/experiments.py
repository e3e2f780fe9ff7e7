"""Environments of experiments."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.models.reference import make_reference
from cardsflow_fmu.utils.multiples import whole_steps
from controllers.validation import require_positive

from .env import CardsflowEnv
from .episodes import Setup
from .randomise import Randomise, random_robots
from .tasks.pose import PoseTask
from .tasks.reach import ReachTask
from .tasks.task import Task
from .tasks.track import TrackTask
from .vector_env import CardsflowVectorEnv

TaskKind = Literal["track", "pose", "reach"]

_TASKS: dict[str, type[Task]] = {"track": TrackTask, "pose": PoseTask, "reach": ReachTask}
_FAR = {"joint": 1.0, "operational": 0.3}
_NEAR = {"joint": 0.05, "operational": 0.02}


def from_experiment(
    experiment: str | Path,
    settings: Mapping[str, Any] | None = None,
    *,
    num_envs: int | None = None,
    **options: Any,
) -> CardsflowEnv | CardsflowVectorEnv:
    """Return the environment of an experiment.

    The controller of the experiment is not used: actions are the commands of the muscles.

    Args:
        experiment: The experiment.toml, or its folder.
        settings: Changes of the experiment by full key.
        num_envs: Number of instances of a vector environment; None for a single environment.
        options: Options of `experiment_setup`, and of `CardsflowEnv` or `CardsflowVectorEnv`.

    Raises:
        InputError: An option is invalid, or batches do not support the experiment.
    """
    environment_options = {k: options.pop(k) for k in _ENVIRONMENT_OPTIONS if k in options}
    setup, steps = experiment_setup(Path(experiment), settings, **options)
    environment_options.setdefault("max_episode_steps", steps)
    if num_envs is None:
        return CardsflowEnv(setup, **environment_options)
    return CardsflowVectorEnv(setup, num_envs, **environment_options)


_ENVIRONMENT_OPTIONS = ("max_episode_steps", "render_mode", "autoreset_mode", "threads")


def experiment_setup(
    path: Path,
    settings: Mapping[str, Any] | None = None,
    *,
    task: TaskKind = "track",
    step: float = 0.02,
    action: Any = "auto",
    randomise: Randomise | None = None,
    variants: int = 32,
    seed: int = 0,
    **task_options: Any,
) -> tuple[Setup, int]:
    """Return the setup of an experiment, and the number of steps of an episode.

    Args:
        path: The experiment.toml, or its folder.
        settings: Changes of the experiment by full key.
        task: `track` to follow the reference; `pose` or `reach`, see `PoseTask` and `ReachTask`.
        step: Length of a step of the environment, in [s]; the plant's step divides it.
        action: Map from actions to commands, see `Actions`.
        randomise: Random robots, see `random_robots` (default: only the robot of the experiment).
        variants: Number of random robots, of which each episode draws one.
        seed: Seed of the random robots.
        task_options: Options of the task.

    Raises:
        InputError: An option is invalid, or batches do not support the experiment.
    """
    if task not in _TASKS:
        raise InputError(f"unknown task {task!r}; known: {', '.join(get_args(TaskKind))}")
    changes = dict(settings or {})
    experiment = Experiment.load(path, changes)
    _require_supported(experiment)
    plant = experiment.plant
    require_positive(step=step)
    count = whole_steps(step, plant.step / plant.substeps, "the step of the plant", key="step")
    steps = max(round(experiment.run.duration / step), 1) if task == "track" else 100
    robot = experiment.plant_robot
    robots = [] if randomise is None else random_robots(path, changes, randomise, variants, seed)
    if task == "track":
        task_options = _tracking(experiment, step, steps) | task_options
    setup = Setup(
        robot,
        _make_task(_TASKS[task], robot, task_options),
        step,
        count,
        plant.integrator,
        action,
        robots,
        folder=experiment.folder,
    )
    return setup, steps


def _make_task(kind: type[Task], robot: Any, options: Mapping[str, Any]) -> Task:
    for name in ("targets", "poses", "weights"):
        if not isinstance(options.get(name) or {}, Mapping):
            raise InputError(f"{name} must have values by name, not be {options[name]!r}")
    try:
        return kind(robot, **options)
    except TypeError as error:
        text = str(error).partition(") ")[2] or str(error)
        raise InputError(f"options of the task: {text.removeprefix('__init__() ')}") from None


def _tracking(experiment: Experiment, step: float, steps: int) -> dict[str, Any]:
    """Return the options of a tracking task."""
    reference, space = make_reference(experiment), experiment.reference.space
    points = [reference.evaluate(k * step) for k in range(steps + 1)]
    start = np.array(experiment.start.q)
    return {
        "start": start,
        "reference": np.array([point.q for point in points]),
        "moves": step * np.array([point.qd for point in points]),
        "space": space,
        "threshold": _NEAR[space],
        "far": _FAR[space],
    }


def _require_supported(experiment: Experiment) -> None:
    """Reject what batches do not simulate."""
    unsupported = {
        "worlds with contacts": experiment.scene is not None,
        "external forces ([disturbance])": experiment.disturbance is not None,
        "an external plant ([fmus.plant])": "plant" in experiment.fmus,
        'the engine "dart"': experiment.plant.engine == "dart",
    }
    for feature, is_used in unsupported.items():
        if is_used:
            raise InputError(f"environments do not support {feature}", file=experiment.file)
