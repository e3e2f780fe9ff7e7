"""Ids of the environments."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import gymnasium

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.examples import examples_folder

from .env import CardsflowEnv
from .episodes import Setup
from .experiments import experiment_setup
from .myosuite import EPISODE, TASKS, myosuite_setup
from .vector_env import CardsflowVectorEnv

_PLANAR: Mapping[str, Any] = {
    "settings": {f"muscles.cable_{k}.f_max": 40.0 for k in (1, 2, 3, 4)},
    "step": 0.01,
}
_POSES = {"joint_1": (-0.5, 0.5), "joint_2": (-0.3, 0.3)}
"""Poses that the cables of the planar arm can hold. The arm is light and unstable, so that larger
forces or longer steps than those of `_PLANAR` make it uncontrollable."""

EXAMPLES: dict[str, tuple[str, Mapping[str, Any], int]] = {
    "PlanarReach-v0": (
        "planar_2r",
        {**_PLANAR, "task": "reach", "poses": _POSES, "threshold": 0.05, "far": 1.5},
        EPISODE,
    ),
    "PlanarPose-v0": (
        "planar_2r",
        {**_PLANAR, "task": "pose", "targets": _POSES, "threshold": 0.1, "far": 2.0},
        EPISODE,
    ),
    "TrackFlower-v0": ("roboy_left_arm", {"task": "track"}, 1600),
}
"""Example, options of `experiment_setup` and number of steps, by id."""


def register_environments() -> None:
    """Register the environments `cardsflow/...` that Gymnasium does not yet have."""
    steps = {name: example[2] for name, example in EXAMPLES.items()}
    for name, count in (steps | dict.fromkeys(TASKS, EPISODE)).items():
        if f"cardsflow/{name}" not in gymnasium.registry:
            gymnasium.register(
                f"cardsflow/{name}",
                entry_point=f"{__name__}:make_env",
                vector_entry_point=f"{__name__}:make_vector_env",
                max_episode_steps=count,
                kwargs={"name": name},
            )


def make_env(name: str, render_mode: str | None = None, **options: Any) -> CardsflowEnv:
    """Return a single environment; Gymnasium limits its episodes."""
    return CardsflowEnv(make_setup(name, **options), render_mode=render_mode)


def make_vector_env(
    name: str,
    num_envs: int = 1,
    max_episode_steps: int | None = None,
    autoreset_mode: Any = "NextStep",
    threads: int = 0,
    render_mode: str | None = None,
    **options: Any,
) -> CardsflowVectorEnv:
    """Return a vector environment."""
    settings = {"autoreset_mode": autoreset_mode, "threads": threads, "render_mode": render_mode}
    return CardsflowVectorEnv(make_setup(name, **options), num_envs, max_episode_steps, **settings)


def make_setup(name: str, model: str | Path | None = None, **options: Any) -> Setup:
    """Return the setup of an environment.

    Args:
        name: Id without `cardsflow/`.
        model: The model's file, for tasks of MyoSuite.
        options: Options of `experiment_setup`, for examples.

    Raises:
        InputError: An option is invalid.
    """
    if name in TASKS:
        if options:
            raise InputError(f"cardsflow/{name} has no option {next(iter(options))!r}")
        return myosuite_setup(name, model)
    if model is not None:
        raise InputError(f"cardsflow/{name} has a robot; use from_experiment for another one")
    example, defaults, _ = EXAMPLES[name]
    return _cached_setup(example, Options({**defaults, **options}))


class Options(dict[str, Any]):
    """Options that can be a key of a cache, since many environments share a setup."""

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(repr(sorted(self.items())))


@lru_cache(maxsize=8)
def _cached_setup(example: str, options: Options) -> Setup:
    return experiment_setup(examples_folder() / example, **options)[0]
