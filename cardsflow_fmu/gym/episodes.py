"""Episodes of n instances of a task: the common part of both environments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from gymnasium.utils import seeding
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot
from cardsflow_fmu.utils.arrays import BoolArray, FloatArray
from sim_dart import Batch
from sim_dart.batch import episodes as core
from sim_dart.batch.arguments import integer

from .actions import ActionMap, Actions
from .tasks.task import Observations, Task


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


class Episodes:
    """Episodes of n instances of a task.

    Args:
        setup: Robot, task and step.
        n: Number of instances.
        max_episode_steps: Number of steps after which an episode is truncated; None: never.
        threads: Number of threads; see `Batch`.

    Attributes:
        batch: The instances.
    """

    def __init__(
        self, setup: Setup, n: int, max_episode_steps: int | None, threads: int = 0
    ) -> None:
        if max_episode_steps is not None:
            integer("max_episode_steps", max_episode_steps, 1)
        self.setup, self.task = setup, setup.task
        options = {"integrator": setup.integrator, "substeps": setup.substeps}
        self.batch = Batch(
            setup.robot, n, setup.step, **options, variants=setup.variants, threads=threads
        )
        self.actions, self._is_seeded = Actions(setup.robot, self.batch, setup.action), False
        self._core = core.Episodes(self.batch, self._rules(max_episode_steps))

    @property
    def targets(self) -> FloatArray:
        """Targets of the episodes, shape (n, k)."""
        return self._core.targets

    @property
    def streams(self) -> NDArray[np.uint64]:
        """States of the random numbers, shape (n,)."""
        return self._core.streams

    def seed(self, seeds: Sequence[int | None], chosen: BoolArray | None = None) -> None:
        """Seed the random numbers of instances; None for a random seed."""
        for i, seed in enumerate(seeds):
            if chosen is None or chosen[i]:
                generator = seeding.np_random(seed)[0].bit_generator
                self.streams[i] = generator.random_raw()
        self._is_seeded = True

    def reset(self, chosen: BoolArray) -> None:
        """Start new episodes of chosen instances."""
        if not self._is_seeded:
            self.seed([None] * self.batch.n)
        self._core.start(chosen)

    def observations(self) -> Observations:
        """Return the observations of all instances, shape (n, k)."""
        return self._core.evaluate().observations

    def evaluate(self) -> core.Evaluation:
        """Return the observations and rewards of the current states."""
        return self._core.evaluate()

    def step(
        self, actions: NDArray[np.floating], ended: BoolArray | None = None
    ) -> core.Evaluation:
        """Advance all instances by one step, and return their observations and rewards.

        Args:
            actions: Actions from -1 to 1, shape (n, k). Values beyond are clipped.
            ended: Flags of instances that start a new episode instead, shape (n,) (default: none).

        Raises:
            InputError: An action is not finite, or the shape is wrong.
        """
        return self._core.step(actions, ended)

    def _rules(self, max_episode_steps: int | None) -> core.Rules:
        task, batch = self.task, self.batch
        start, activations = task.start(), task.activation_columns(batch)
        columns = batch.columns("states")
        return core.Rules(
            q=start.q,
            targets=start.targets,
            points=start.points,
            reference=task.reference,
            rest=self.actions.rest,
            activation=self.setup.rest,
            actions=self.actions.table,
            is_sigmoid=self.actions.is_sigmoid,
            features=task.features(batch),
            activation_columns=[columns[k] for k in activations],
            near=task.near,
            beyond=task.beyond,
            far=task.far,
            first_end=task.first_end,
            last=np.inf if max_episode_steps is None else max_episode_steps,
            weights=[task.weights[name] for name in (task.term, "bonus", "act_reg", "penalty")],
        )
