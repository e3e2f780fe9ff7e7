"""Task: what an environment observes and rewards, for all instances of a batch at once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import Batch

Terms = dict[str, NDArray[Any]]


Observations = NDArray[np.float32]

Draw = Callable[[int], FloatArray]
"""Function of a count that draws numbers from 0 to 1 for i instances, shape (i, count)."""


class Start(NamedTuple):
    """Starts of i episodes.

    Attributes:
        q: Joint positions, shape (i, dofs), or (dofs,) for all, in [rad] or [m].
        target: Targets of the episodes, shape (i, k).
    """

    q: FloatArray
    target: FloatArray


class Task(ABC):
    """Task of n instances.

    Args:
        robot: The robot.
        weights: Changes of the weights of the reward terms.

    Reward terms: the one named `term` is minus the distance d to the target; `bonus` is 1 below
    `beyond`, 2 below `near`; `penalty` is -1 beyond `far`, where the episode ends; `act_reg` is
    minus the norm of the activations divided by their number.

    Attributes:
        near: Distance below which the task is solved.
        beyond: Distance below which the bonus begins.
        far: Distance beyond which an episode ends.
        weights: Weights of the reward terms, whose sum is the reward.
        parts: Parts of `observe` that controllers have, see `cardsflow_fmu.experiment.policy`;
            empty if policies of this task cannot control experiments.
        space: Space of the reference that contains the targets.
    """

    term: ClassVar[str]
    default_weights: ClassVar[Mapping[str, float]]
    first_end: ClassVar[int] = 0
    """First step with which an episode can end."""
    parts: tuple[str, ...] = ()
    near: float
    beyond: float
    far: float

    def __init__(self, robot: Robot, weights: Mapping[str, float] | None) -> None:
        self.robot = robot
        self.space: Space = "joint"
        self.weights = dict(self.default_weights)
        for name, weight in (weights or {}).items():
            if name not in self.weights:
                raise UnknownNameError("reward term", name, self.weights)
            if not np.isfinite(weight):
                raise InputError(f"the weight of {name!r} must be finite, not {weight}")
            self.weights[name] = float(weight)
        self._activations: list[int] | None = None

    @abstractmethod
    def start(self, draw: Draw) -> Start:
        """Return the starts of episodes.

        Args:
            draw: Random numbers of the instances.
        """

    @abstractmethod
    def observe(self, batch: Batch, targets: FloatArray) -> list[FloatArray]:
        """Return the parts of the observation before the activations, each of shape (n, k).

        Args:
            batch: The instances.
            targets: Targets of the episodes, shape (n, k).
        """

    @abstractmethod
    def distance(self, batch: Batch, targets: FloatArray) -> FloatArray:
        """Return the distances to the target, shape (n,), as for `observe`."""

    def terms(self, batch: Batch, targets: FloatArray) -> Terms:
        """Return the reward terms, `solved` and `done`, each of shape (n,), as for `observe`."""
        distance = self.distance(batch, targets)
        done, solved = distance > self.far, distance < self.near
        if self.first_end:
            done &= batch.ticks >= self.first_end
        return {
            self.term: -distance,
            "sparse": -distance,
            "penalty": -1.0 * done,
            "done": done,
            "bonus": 1.0 * solved + (distance < self.beyond),
            "solved": solved,
        }

    def activation_columns(self, batch: Batch) -> list[int]:
        """Return the columns of the activations in the states of muscles."""
        if self._activations is None:
            names = batch.state_names
            self._activations = [k for k, n in enumerate(names) if n.startswith("activation.")]
        return self._activations

    def activations(self, batch: Batch) -> FloatArray:
        """Return the activations of the muscles that have one, shape (n, a)."""
        columns = self.activation_columns(batch)
        return batch.states if len(columns) == batch.states.shape[1] else batch.states[:, columns]

    def observation(self, batch: Batch, targets: FloatArray) -> Observations:
        """Return the observations: q, qd times the length of a step, the parts, activations."""
        rates = batch.qd * batch.step_size
        parts = [batch.q, rates, *self.observe(batch, targets), self.activations(batch)]
        return np.concatenate(parts, axis=1, dtype=np.float32, casting="same_kind")

    def rewards(self, batch: Batch, targets: FloatArray) -> tuple[FloatArray, Terms]:
        """Return the rewards, shape (n,), and all terms."""
        terms = self.terms(batch, targets)
        active = self.activations(batch)
        size = max(active.shape[1], 1)
        terms["act_reg"] = -np.sqrt(np.einsum("ij,ij->i", active, active)) / size
        reward = np.zeros(batch.n)
        for name, weight in self.weights.items():
            if weight:
                reward += weight * terms[name]
        return reward, terms


def norms(rows: FloatArray) -> FloatArray:
    """Return the 2-norms of rows, shape (n,)."""
    lengths: FloatArray = np.sqrt(np.einsum("ij,ij->i", rows, rows))
    return lengths
