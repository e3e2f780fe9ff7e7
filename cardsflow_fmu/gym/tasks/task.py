"""Task: what an environment observes and rewards, for all instances of a batch at once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.validation import require_positive
from sim_dart import Batch
from sim_dart.batch.episodes import Evaluation
from sim_dart.batch.features import Feature, features

Terms = dict[str, NDArray[Any]]
Observations = NDArray[np.float32]


class Start(NamedTuple):
    """Ranges from which the starts of episodes are drawn uniformly.

    Attributes:
        q: Joint positions, from low to high, shape (2, dofs), in [rad] or [m].
        targets: Targets, from low to high, shape (2, k).
        points: Targets of which each episode draws one instead, shape (i, k), or None.
    """

    q: FloatArray
    targets: FloatArray
    points: FloatArray | None = None


class Task(ABC):
    """Task of n instances.

    Args:
        robot: The robot.
        weights: Changes of the weights of the reward terms.
        threshold: Distance below which the task is solved, for each of `count` points.
        far: Distance beyond which an episode ends, for each point.
        count: Number of points.

    Raises:
        InputError: A number is invalid.
        UnknownNameError: A reward term does not exist.

    Reward terms: the one named `term` is minus the distance d to the target; `bonus` is 1 below
    `beyond`, 2 below `near`; `penalty` is -1 beyond `far`, where the episode ends; `act_reg` is
    minus the norm of the activations divided by their number.

    Attributes:
        initial: Initial pose, shape (dofs,), in [rad] or [m].
        near: Distance below which the task is solved.
        beyond: Distance below which the bonus begins.
        far: Distance beyond which an episode ends.
        weights: Weights of the reward terms, whose sum is the reward.
        layout: Parts of the observation between velocities and activations, see
            `cardsflow_fmu.experiment.policy`. The first targets are those of `error`.
        space: Space of the targets, `joint` or `operational`.
        columns: Coordinates of this space that have targets; None: all, so that policies can
            control experiments.
        reference: Targets of every step of an episode, shape (steps + 1, k); None: constant ones.
    """

    term: ClassVar[str]
    default_weights: ClassVar[Mapping[str, float]]
    first_end: ClassVar[int] = 0
    """First step with which an episode can end."""
    layout: tuple[str, ...]
    bonus_range: ClassVar[float] = 2.0
    """Distance below which the bonus begins, over that below which the task is solved."""

    def __init__(
        self,
        robot: Robot,
        weights: Mapping[str, float] | None,
        threshold: float,
        far: float,
        count: int = 1,
    ) -> None:
        require_positive(threshold=threshold, far=far)
        self.near, self.far = count * threshold, count * far
        self.beyond = self.bonus_range * self.near
        self.robot, self.initial = robot, np.array([c.initial for c in robot.coordinates])
        self.space: Space = "joint"
        self.columns: list[int] | None = None
        self.reference: FloatArray | None = None
        self.weights = dict(self.default_weights)
        for name, weight in (weights or {}).items():
            if name not in self.weights:
                raise UnknownNameError("reward term", name, self.weights)
            if not isinstance(weight, int | float) or not np.isfinite(weight):
                raise InputError(f"the weight of {name!r} must be finite, not {weight!r}")
            self.weights[name] = float(weight)

    def choose(self, kind: str, owners: Sequence[str], names: Iterable[str]) -> list[int]:
        """Set and return the coordinates with targets.

        Args:
            kind: What the names are, for messages.
            owners: Name of each coordinate.
            names: Names of those with targets.
        """
        for name in names:
            if name not in owners:
                raise UnknownNameError(kind, name, sorted({*owners}))
        columns = [k for name in names for k, owner in enumerate(owners) if owner == name]
        self.columns = None if columns == list(range(len(owners))) else columns
        return columns

    @abstractmethod
    def start(self) -> Start:
        """Return the ranges of starts of episodes."""

    def features(self, batch: Batch) -> Feature:
        """Return the features of the observation; their norms are distance and effort.

        The observation contains q, qd times the length of a step, the parts, and activations.
        """
        at = batch.columns("q" if self.space == "joint" else "task_position")
        at = at if self.columns is None else [at[k] for k in self.columns]
        activations = [batch.columns("states")[k] for k in self.activation_columns(batch)]
        table = {
            "q": features(batch.columns("q")),
            "qd": features(batch.columns("qd"), batch.step_size),
            "y": features(at),
            "error": features(at, -1.0, target=0, norm=0),
            "rate": features(np.full(len(at), -1), target=len(at)),
            "activations": features(activations, norm=1),
        }
        return np.concatenate([table[part] for part in ("q", "qd", *self.layout, "activations")])

    def activation_columns(self, batch: Batch) -> list[int]:
        """Return the columns of the activations in the states of muscles."""
        return [k for k, n in enumerate(batch.state_names) if n.startswith("activation.")]

    def terms(self, result: Evaluation) -> Terms:
        """Return the reward terms by name, `solved`, `done`, and `diverged` if an instance has."""
        distance, bonus, effort, penalty = result.terms
        terms: Terms = {
            **{self.term: distance, "sparse": distance, "penalty": penalty, "done": result.done},
            **{"bonus": bonus, "solved": result.solved, "act_reg": effort},
        }
        return terms | {"diverged": result.diverged} if result.diverged.any() else terms
