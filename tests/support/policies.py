"""Policies with random networks, for the planar arm."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from support.robots.robots import PLANAR_2R

from cardsflow_fmu.experiment.policy import Policy
from cardsflow_fmu.gym import from_experiment
from cardsflow_fmu.gym.export import export_policy

_FUNCTIONS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "linear": lambda x: x,
    "tanh": np.tanh,
    "relu": lambda x: np.maximum(x, 0.0),
    "elu": lambda x: np.where(x > 0.0, x, np.expm1(np.minimum(x, 0.0))),
    "sigmoid": lambda x: 1.0 / (1.0 + np.exp(-x)),
}


def actions_of(policy: Policy, observation: np.ndarray) -> np.ndarray:
    """Return the clipped actions of a policy, computed with NumPy."""
    x = (observation - policy.mean) / policy.sd
    for layer in policy.layers:
        x = _FUNCTIONS[layer.activation](x @ layer.weights.T + layer.bias)
    return np.clip(x, -1.0, 1.0)


def ranges(policy: Policy) -> list[np.ndarray]:
    """Return the smallest commands, the largest commands, and the fallback."""
    keys = ("low", "high", "fallback")
    return [np.array([getattr(output, key) for output in policy.outputs]) for key in keys]


def random_network(sizes: list[int]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return weights and biases of layers with the given numbers of inputs and outputs."""
    rng = np.random.default_rng(0)
    pairs = itertools.pairwise(sizes)
    return [(rng.normal(size=(b, a)) / np.sqrt(a), 0.1 * rng.normal(size=b)) for a, b in pairs]


def random_policy(folder: Path) -> dict[str, Any]:
    """Write a policy, and return the settings of an experiment with it."""
    env, file = from_experiment(PLANAR_2R, task="pose"), folder / "policy.json"
    export_policy(env, random_network([6, 16, 4]), file, activation="tanh")
    policy = {"controller.type": "policy", "controller.policy": str(file)}
    return {**policy, "controller.period": 0.02}
