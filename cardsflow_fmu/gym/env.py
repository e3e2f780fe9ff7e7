"""Environment of Gymnasium with one robot."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError

from .episodes import Episodes, Setup
from .image import image
from .tasks.task import Observations

ONE = np.ones(1, dtype=np.bool_)


def spaces(episodes: Episodes) -> tuple[Any, Any]:
    """Return the observation and the action space of one instance."""
    size = episodes.observations().shape[1]
    observation = Box(-np.inf, np.inf, (size,), np.float32)
    return observation, Box(-1.0, 1.0, (episodes.actions.size,), np.float32)


class CardsflowEnv(gymnasium.Env[Observations, NDArray[np.float32]]):
    """Robot with a task as an environment of Gymnasium.

    Observations are q, qd times the length of a step, the values of the task and the activations of
    the muscles. Actions are numbers from -1 to 1, one for each driven muscle and motor. The info of
    a step contains the terms of the reward and `solved`. An episode of a state that diverges ends
    with the penalty.

    Args:
        setup: Robot, task and step.
        max_episode_steps: Number of steps after which an episode is truncated; None: never.
        render_mode: `rgb_array`, or None.

    Raises:
        InputError: A setting is invalid, or the robot is not supported.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012

    def __init__(
        self,
        setup: Setup,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        modes = self.metadata["render_modes"]
        if render_mode is not None and render_mode not in modes:
            raise InputError(f"render_mode must be one of {modes}, not {render_mode!r}")
        self.render_mode = render_mode
        self.episodes = Episodes(setup, 1, max_episode_steps, threads=1)
        self.metadata = self.metadata | {"render_fps": max(1, round(1.0 / setup.step))}
        self.observation_space, self.action_space = spaces(self.episodes)
        self._frames: list[NDArray[np.float64]] = []

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Start an episode; see `gymnasium.Env.reset`."""
        super().reset(seed=seed)
        if seed is not None:
            self.episodes.seed([seed])
        self.episodes.reset(ONE)
        self._frames = [self._state()]
        return self.episodes.observations()[0], {}

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observations, float, bool, bool, dict[str, Any]]:
        """Advance by one step; see `gymnasium.Env.step`."""
        array = np.asarray(action)
        if array.shape != self.action_space.shape:
            raise InputError(f"action must have shape {self.action_space.shape}, not {array.shape}")
        result = self.episodes.step(array[None])
        terms = self.episodes.task.terms(result)
        self._frames.append(self._state())
        info = {name: values[0].item() for name, values in terms.items()}
        ends = bool(result.terminated[0]), bool(result.truncated[0])
        return result.observations[0], float(result.rewards[0]), *ends, info

    def render(self) -> NDArray[np.uint8] | None:
        """Return an image of the robot, shape (height, width, 3)."""
        if self.render_mode is None:
            return None
        batch = self.episodes.batch
        return image(self.episodes.setup.robot, batch.q[0], batch.tensions()[0])

    def show(self) -> Any:
        """Return a page of the viewer with the current episode; else, open the browser."""
        from .replay import show_episode

        return show_episode(self.episodes.setup, np.array(self._frames))

    def _state(self) -> NDArray[np.float64]:
        batch = self.episodes.batch
        return np.concatenate([batch.q[0], batch.tensions()[0]])
