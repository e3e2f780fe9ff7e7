"""Episodes: starts, commands for actions, observations and rewards of the instances of a batch."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim_dart.core.arrays import BoolArray, FloatArray

from .arguments import rows
from .batch import Batch
from .binding import EPISODE_FIELDS, batch_library
from .features import Feature

ACTION = np.dtype([("muscle", "i4"), ("dof", "i4"), ("low", "f8"), ("high", "f8")])
"""Range of an action: index of a muscle or of a coordinate with a motor; -1 for the other."""

TERMS = ("distance", "bonus", "effort", "penalty")
"""Terms of rewards, in the order of `enum episode_term`."""

_FLAGS = 5

_SAME_NUMBERS = ("is_sigmoid", "first_end", "near", "beyond", "far", "last")


class Evaluation(NamedTuple):
    """Observations and rewards of all instances.

    Attributes:
        observations: Shape (n, features); 0 for instances that diverged.
        rewards: Shape (n,).
        terminated: Flags of instances whose episode ends, shape (n,).
        truncated: Flags of instances whose episode reaches its largest number of steps.
        terms: Terms of the rewards in the order of `TERMS`, shape (4, n).
        done: Flags of instances whose distance is beyond `far`.
        solved: Flags of instances whose distance is below `near`.
        diverged: Flags of instances whose state diverged.
    """

    observations: NDArray[np.float32]
    rewards: FloatArray
    terminated: BoolArray
    truncated: BoolArray
    terms: FloatArray
    done: BoolArray
    solved: BoolArray
    diverged: BoolArray


@dataclass(frozen=True)
class Rules:
    """Rules of episodes.

    Attributes:
        q: Joint positions at the start, from low to high, shape (2, dofs).
        targets: Targets, from low to high, shape (2, k).
        points: Targets of which each episode draws one instead, shape (i, k), or None.
        reference: Targets at each tick instead of constant ones, shape (ticks, k), or None.
        rest: Commands in whose equilibrium the muscles start, shape (m,).
        activation: Activation of the muscles at the start instead; None: that of the equilibrium.
        actions: Ranges of the actions, of the type `ACTION`.
        is_sigmoid: Whether commands of muscles are 1 / (1 + exp(-5 (a - 0.5))) for actions a.
        features: Features of the observation; their norms are distance and effort.
        activation_columns: Columns of the activations in the working memory.
        near: Distance below which the task is solved.
        beyond: Distance below which the bonus begins.
        far: Distance beyond which an episode ends.
        first_end: First tick with which an episode can end.
        last: Number of ticks after which an episode is truncated, or infinity.
        weights: Weights of the terms, in the order of `TERMS`.
    """

    q: FloatArray
    targets: FloatArray
    points: FloatArray | None
    reference: FloatArray | None
    rest: FloatArray
    activation: float | None
    actions: NDArray[Any]
    is_sigmoid: bool
    features: Feature
    activation_columns: list[int]
    near: float
    beyond: float
    far: float
    first_end: int
    last: float
    weights: list[float]


_Results = tuple[NDArray[np.float32], FloatArray, BoolArray]


class _Episodes(ctypes.Structure):
    _fields_ = EPISODE_FIELDS


class Episodes:
    """Episodes of the instances of a batch, computed in C.

    Random numbers are those of the generator SplitMix64, with one stream for each instance. So an
    instance draws the same numbers alone and among others.

    Attributes:
        streams: States of the random numbers, shape (n,), which seed them.
        targets: Targets of the episodes, shape (n, k).
    """

    def __init__(self, batch: Batch, rules: Rules) -> None:
        self.batch, self.rules = batch, rules
        first = rules.targets[0] if rules.points is None else rules.points[0]
        self.streams = np.zeros(batch.n, dtype=np.uint64)
        self.targets: FloatArray = np.tile(first, (batch.n, 1))
        self._memory = _Episodes(**self._numbers(), **self._addresses())
        self._address = ctypes.addressof(self._memory)

    def start(self, chosen: BoolArray) -> None:
        """Start new episodes of chosen instances.

        Args:
            chosen: Flags of the instances, shape (n,).

        Raises:
            InputError: Loops of an instance cannot be closed.
        """
        flags = np.ascontiguousarray(chosen)
        batch_library().core_episodes_start(self._address, 0, self.batch.n, flags.ctypes.data)
        self.batch._require_started(flags)

    def step(self, actions: NDArray[Any], ended: BoolArray | None = None) -> Evaluation:
        """Step all instances, and return their observations and rewards.

        Args:
            actions: Actions from -1 to 1, shape (n, k) or (k,). Values beyond are clipped.
            ended: Flags of instances that start an episode instead, shape (n,) (default: none).

        Raises:
            InputError: An action is not finite, the shape is wrong, or loops of an instance that
                starts cannot be closed.
        """
        shape = self.batch.n, len(self.rules.actions)
        values = np.ascontiguousarray(rows("actions", actions, shape))
        starts = None if ended is None or not ended.any() else np.ascontiguousarray(ended)
        results = self._new_results()
        observations, *others = (array.ctypes.data for array in results)
        inputs, flags = values.ctypes.data, None if starts is None else starts.ctypes.data

        def run(part: slice, group: int | None) -> None:
            first = part.start
            batch_library().core_episodes_step(
                *(self._address, first, part.stop - first, inputs + first * values.strides[0]),
                *(None if flags is None else flags + first, group),
                *(observations + first * results[0].strides[0], *others),
            )

        self.batch._share_step(run)
        if starts is not None:
            self.batch._require_started(starts)
        return _evaluation(results)

    def evaluate(self) -> Evaluation:
        """Return the observations and rewards of the current states."""
        results = self._new_results()
        addresses = (array.ctypes.data for array in results)
        batch_library().core_episodes_evaluate(self._address, 0, self.batch.n, None, *addresses)
        return _evaluation(results)

    def _new_results(self) -> _Results:
        n, size = self.batch.n, len(self.rules.features)
        numbers, flags = np.empty((1 + len(TERMS), n)), np.empty((_FLAGS, n), dtype=np.bool_)
        return np.empty((n, size), np.float32), numbers, flags

    def _numbers(self) -> dict[str, Any]:
        rules, batch = self.rules, self.batch
        h, steps, is_runge_kutta = batch._rule()
        return {
            "instances": batch.n,
            "width": self.targets.shape[1],
            "draws_targets": _differ(rules.targets),
            "draws_q": _differ(rules.q),
            "blob_count": len(batch._instances.cores),
            "point_count": 0 if rules.points is None else len(rules.points),
            "reference_rows": 0 if rules.reference is None else len(rules.reference),
            "activations": len(rules.activation_columns),
            "activation": -1.0 if rules.activation is None else rules.activation,
            "action_count": len(rules.actions),
            "feature_count": len(rules.features),
            "h": h,
            "steps": steps,
            "is_runge_kutta": is_runge_kutta,
            "weights": (ctypes.c_double * len(TERMS))(*rules.weights),
            **{name: getattr(rules, name) for name in _SAME_NUMBERS},
        }

    def _addresses(self) -> dict[str, Any]:
        rules, batch = self.rules, self.batch
        memory, stride, _ = batch._instances.place(slice(0, batch.n))
        batch._has_torques = bool((rules.actions["dof"] >= 0).any())
        blobs = [core.blob for core in batch._instances.cores]
        arrays = {
            "streams": self.streams,
            "ticks": batch.ticks,
            "targets": self.targets,
            "q": np.zeros(batch.q.shape),
            "commands": batch.commands,
            "torques": batch._torques if batch._has_torques else None,
            "answers": batch._answers,
            "variants": batch.variant,
            "moving": np.zeros(batch.n, dtype=np.uint8),
            "target_low": rules.targets[0],
            "target_high": rules.targets[1],
            "points": rules.points,
            "q_low": rules.q[0],
            "q_high": rules.q[1],
            "blobs": np.array([blob.ctypes.data for blob in blobs], dtype=np.uintp),
            "blob_sizes": np.array([blob.nbytes for blob in blobs], dtype=np.uintp),
            "zeros": np.zeros(batch.q.shape[1]),
            "rest": rules.rest,
            "activation_columns": np.array(rules.activation_columns, dtype=np.int32),
            "reference": rules.reference,
            "actions": rules.actions,
            "features": rules.features,
        }
        used = {k: np.ascontiguousarray(a) for k, a in arrays.items() if a is not None}
        self._arrays = list(used.values())  # C has only their addresses
        return {"memory": memory, "stride": stride, **{k: a.ctypes.data for k, a in used.items()}}

    def __reduce__(self) -> tuple[Any, ...]:
        """Describe a copy by its state, since pointers to C cannot be copied."""
        return _restored_episodes, (self.batch, self.rules, self.streams, self.targets)


def _evaluation(results: _Results) -> Evaluation:
    observations, numbers, flags = results
    ends = flags[0], flags[1]
    return Evaluation(observations, numbers[0], *ends, numbers[1:], flags[2], flags[3], flags[4])


def _differ(ends: FloatArray) -> bool:
    return bool((ends[0] != ends[1]).any())


def _restored_episodes(
    batch: Batch, rules: Rules, streams: NDArray[Any], targets: FloatArray
) -> Episodes:
    episodes = Episodes(batch, rules)
    episodes.streams[:], episodes.targets[:] = streams, targets
    return episodes
