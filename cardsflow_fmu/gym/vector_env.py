"""Vector environment of Gymnasium: many robots that the C core steps together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.arrays import BoolArray

from .env import spaces
from .episodes import Episodes, Setup
from .tasks.task import Observations, Terms

Step = tuple[Observations, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]


class CardsflowVectorEnv(VectorEnv[Observations, NDArray[np.float32], NDArray[Any]]):
    """Many robots with a task as a vector environment of Gymnasium.

    Instance i with the seed s + i behaves as a `CardsflowEnv` with this seed. Each step is computed
    by `sim_dart.Batch`, in threads.

    Args:
        setup: Robot, task and step.
        num_envs: Number of instances.
        max_episode_steps: Number of steps after which an episode is truncated; None: never.
        autoreset_mode: When finished episodes are reset; see `gymnasium.vector.AutoresetMode`.
        threads: Number of threads (default: number of processors, at most 8).
        render_mode: Must be None; render a `CardsflowEnv` instead.

    Raises:
        InputError: A setting is invalid, or the robot is not supported.
    """

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        setup: Setup,
        num_envs: int = 1,
        max_episode_steps: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        threads: int = 0,
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None:
            raise InputError("vector environments do not render; use a single environment")
        try:
            self._mode = AutoresetMode(autoreset_mode)
        except ValueError:
            modes = ", ".join(mode.value for mode in AutoresetMode)
            raise InputError(f"unknown autoreset_mode {autoreset_mode!r}; known: {modes}") from None
        self.metadata = {"autoreset_mode": self._mode}
        self.episodes = Episodes(setup, num_envs, max_episode_steps, threads)
        self.num_envs = self.episodes.batch.n
        self.single_observation_space, self.single_action_space = spaces(self.episodes)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._ended = np.zeros(self.num_envs, dtype=np.bool_)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observations, dict[str, Any]]:
        """Start episodes.

        Args:
            seed: Seed of the first instance, which the others count up; or one seed per instance.
            options: `reset_mask`: flags of the instances to reset, shape (n,) (default: all).
        """
        chosen = np.ones(self.num_envs, dtype=np.bool_)
        if options is not None and "reset_mask" in options:
            chosen = np.asarray(options["reset_mask"])
            if chosen.shape != (self.num_envs,) or chosen.dtype != np.bool_ or not chosen.any():
                raise InputError(f"reset_mask must be {self.num_envs} flags, at least one is true")
        if seed is not None:
            seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, int) else seed
            if not isinstance(seeds, Sequence) or len(seeds) != self.num_envs:
                raise InputError(f"seed must be a number or {self.num_envs} numbers, not {seed!r}")
            self.episodes.seed(seeds, chosen)
        self.episodes.reset(chosen)
        self._ended[chosen] = False
        return self.episodes.observations(), {}

    def step(self, actions: NDArray[np.float32]) -> Step:
        """Advance all instances by one step; see `gymnasium.vector.VectorEnv.step`."""
        before = self._ended
        if self._mode is AutoresetMode.DISABLED and before.any():
            which = np.flatnonzero(before)
            raise InputError(f"episodes {which} have ended; reset them with options reset_mask")
        result = self.episodes.step(actions, before)
        observations, rewards, terminated, truncated = result[:4]
        terms = self.episodes.task.terms(result)
        runs = ~before
        infos: dict[str, Any] = {**terms, **dict.fromkeys((f"_{name}" for name in terms), runs)}
        self._ended = terminated | truncated
        if self._mode is AutoresetMode.SAME_STEP and self._ended.any():
            ended = self._ended
            infos |= dict.fromkeys((f"_{name}" for name in terms), ~ended)
            infos |= _final_infos(ended, observations, terms)
            self.episodes.reset(ended)
            observations = self.episodes.observations()
            self._ended = np.zeros(self.num_envs, dtype=np.bool_)
        return observations, rewards, terminated, truncated, infos


def _final_infos(ended: BoolArray, observations: Observations, terms: Terms) -> dict[str, Any]:
    """Return the last observations and infos of episodes that ended, as Gymnasium expects."""
    final = np.full(len(ended), None, dtype=object)
    for i in np.flatnonzero(ended):
        final[i] = observations[i].copy()
    info = {**terms, **{f"_{name}": ended.copy() for name in terms}}
    return {
        **{"final_obs": final, "_final_obs": ended.copy()},
        **{"final_info": info, "_final_info": ended.copy()},
    }
