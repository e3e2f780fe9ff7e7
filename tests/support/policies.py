"""Policies with random networks, for the planar arm."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
from support.robots.robots import PLANAR_2R

from cardsflow_fmu.gym import from_experiment
from cardsflow_fmu.gym.export import export_policy


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
