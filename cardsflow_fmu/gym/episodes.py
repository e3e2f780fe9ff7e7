"""Episodes of n instances of a task: the common part of both environments."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot, SimulationError
from cardsflow_fmu.utils.arrays import BoolArray, FloatArray
from sim_dart import Batch
from sim_dart.batch.arguments import integer

from .actions import ActionMap, Actions
from .draws import Draws
from .tasks.task import Observations, Task, Terms


@dataclass(frozen=True)
class Setup:
    """Robot, task and step of an environment.

    Attributes:
        robot: The robot.
        task: The task.
        step: Length of a step of the environment, in [s].
        substeps: Integrator steps per step of the environment.
        integrator: `euler` or `rk4`.
        action: Map from actions to commands, see `Actions`.
        variants: Robots of which each episode draws one (default: only `robot`).
        rest: Activation of the muscles at the start; None: the smallest in equilibrium.
        folder: Folder of the robot with its meshes, for the viewer; None without one.
    """

    robot: Robot
    task: Task
    step: float = 0.02
    substeps: int = 10
    integrator: Any = "euler"
    action: ActionMap = "auto"
    variants: Sequence[Robot] = ()
    rest: float | None = None
    folder: Any = field(default=None, compare=False)


class Transition(NamedTuple):
    """Result of a step of all instances, arrays with n rows."""

    observations: Observations
    rewards: FloatArray
    terminated: BoolArray
    truncated: BoolArray
    terms: Terms


class Episodes:
    """Episodes of n instances of a task.

    Args:
        setup: Robot, task and step.
        n: Number of instances.
        max_episode_steps: Number of steps after which an episode is truncated; None: never.
        threads: Number of threads; see `Batch`.

    Attributes:
        batch: The instances.
        targets: Targets of the episodes, shape (n, k).
    """

    def __init__(
        self, setup: Setup, n: int, max_episode_steps: int | None, threads: int = 0
    ) -> None:
        if max_episode_steps is not None:
            integer("max_episode_steps", max_episode_steps, 1)
        self.setup, self.task = setup, setup.task
        self._max = np.inf if max_episode_steps is None else max_episode_steps
        options = {"integrator": setup.integrator, "substeps": setup.substeps}
        self.batch = Batch(
            setup.robot, n, setup.step, **options, variants=setup.variants, threads=threads
        )
        self.actions = Actions(setup.robot, self.batch, setup.action)
        self._draws, self._is_seeded = Draws(n), False
        first = self.task.start(lambda count: np.zeros((n, count)))
        self.targets: FloatArray = np.array(first.target)
        self._features = self.task.features(self.batch)
        self._effort = max(len(self.task.activation_columns(self.batch)), 1)
        self._q = np.broadcast_to(first.q, self.batch.q.shape).copy()

    def seed(self, seeds: Sequence[int | None], chosen: BoolArray | None = None) -> None:
        """Seed the random numbers of instances; None for a random seed."""
        for i, seed in enumerate(seeds):
            if chosen is None or chosen[i]:
                self._draws.seed(i, seed)
        self._is_seeded = True

    def reset(self, chosen: BoolArray) -> None:
        """Start new episodes of chosen instances."""
        if not self._is_seeded:
            self.seed([None] * self.batch.n)
        variant, draw = None, partial(self._draws.uniform, np.flatnonzero(chosen))
        self._q[chosen], self.targets[chosen] = self.task.start(draw)
        if len(self.setup.variants) > 1:
            variant = self.batch.variant.copy()
            variant[chosen] = len(self.setup.variants) * draw(1)[:, 0]
        self.batch.reset(chosen, self._q, commands=self.actions.rest, variant=variant)
        if self.setup.rest is not None:
            for column in self.task.activation_columns(self.batch):
                self.batch.states[chosen, column] = self.setup.rest

    def observations(self) -> Observations:
        """Return the observations of all instances, shape (n, k)."""
        return self.batch.features(self._features, self.targets)[0]

    def evaluate(self) -> tuple[Observations, FloatArray, Terms]:
        """Return the observations, rewards and terms of the current states."""
        observations, (distance, effort) = self.batch.features(self._features, self.targets)
        ticks = self.batch.ticks
        return observations, *self.task.rewards(distance, effort / self._effort, ticks)

    def step(self, actions: NDArray[np.floating], ended: BoolArray | None = None) -> Transition:
        """Advance all instances by one step.

        Args:
            actions: Actions from -1 to 1, shape (n, k). Values beyond are clipped.
            ended: Flags of instances that start a new episode instead, shape (n,) (default: none).

        Raises:
            InputError: An action is not finite, or the shape is wrong.
        """
        inputs, moving = self.actions.commands(actions), None
        if ended is not None and ended.any():
            self.reset(ended)
            moving = ~ended
        with suppress(SimulationError):  # `diverged` specifies the instances
            self.batch.step(*inputs, moving)
        if self.task.reference is not None:
            np.take(self.task.reference, self.batch.ticks, 0, out=self.targets, mode="clip")
        observations, rewards, terms = self.evaluate()
        terminated, bad = terms["done"], self.batch.diverged
        if bad.any():
            rewards[bad] = -self.task.weights["penalty"]
            terminated = terminated | bad
            terms["diverged"] = bad
        if moving is not None:
            rewards[ended], terminated = 0.0, terminated & moving
        return Transition(observations, rewards, terminated, self.batch.ticks >= self._max, terms)
