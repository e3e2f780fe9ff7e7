"""Networks, normalisation and results that both ways of training share."""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np
import torch
from torch import nn

import cardsflow_fmu.gym  # noqa: F401  registers cardsflow/...
from addin_sdfusion.robot import InputError
from cardsflow_fmu.gym.export import export_policy

LAMBDA = 0.95
"""Decay of generalised advantages."""


class Row(NamedTuple):
    """Row of a learning curve."""

    seconds: float
    cpu_seconds: float
    steps: int
    episode_return: float
    solved: float

    def text(self) -> str:
        """Return the row as a line."""
        form = "{:6.0f} s ({:.0f} s CPU) {:9d} steps  return {:8.1f}  solved {:.3f}"
        return form.format(*self)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of both ways of training."""
    parser.add_argument("--minutes", type=float, default=5.0, help="time limit (default: 5)")
    parser.add_argument("--cpu", action="store_true", help="limit processor time, not wall time")
    parser.add_argument(
        "--goal",
        type=float,
        default=0.97,
        help="share of solved episodes at which training ends (default: 0.97)",
    )
    parser.add_argument("--seed", type=int, default=0, help="(default: 0)")
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("trained"), help="folder (default: trained)"
    )


class Normaliser:
    """Mean and standard deviation of rows of numbers.

    Args:
        size: Length of a row.

    Attributes:
        mean: Means, shape (size,).
        sd: Standard deviations, shape (size,).
    """

    def __init__(self, size: int) -> None:
        self._count, self.mean, self.sd = 1e-4, np.zeros(size), np.ones(size)

    def update(self, rows: np.ndarray) -> None:
        """Include rows, shape (n, size)."""
        total = self._count + len(rows)
        difference, share = rows.mean(axis=0) - self.mean, len(rows) / total
        variance = (1.0 - share) * (self.sd**2 + share * difference**2) + share * rows.var(axis=0)
        self.mean, self.sd = self.mean + share * difference, np.sqrt(variance + 1e-12)
        self._count = total

    def __call__(self, rows: np.ndarray | torch.Tensor) -> torch.Tensor:
        """Return the normalised rows, with gradients."""
        kind = torch.get_default_dtype()
        mean, sd = (torch.as_tensor(x, dtype=kind) for x in (self.mean, self.sd))
        return (torch.as_tensor(rows, dtype=kind) - mean) / sd


def network(inputs: int, outputs: int, width: int = 64, gain: float = 1.0) -> nn.Sequential:
    """Return a network with two inner layers."""
    layers = [nn.Linear(inputs, width), nn.Linear(width, width), nn.Linear(width, outputs)]
    for layer, scale in zip(layers, (np.sqrt(2.0), np.sqrt(2.0), gain), strict=True):
        nn.init.orthogonal_(layer.weight, scale)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(layers[0], nn.Tanh(), layers[1], nn.Tanh(), layers[2])


def make(name: str, count: int, model: str | None = None, **options: Any) -> Any:
    """Return the vector environment of an id; tasks of MyoSuite need its model."""
    options = options if model is None else {**options, "model": model}
    return gymnasium.make_vec(name, count, autoreset_mode="SameStep", **options)


def advantages(
    rewards: torch.Tensor, ends: torch.Tensor, values: torch.Tensor, discount: float
) -> torch.Tensor:
    """Return generalised advantages, shape (steps, n), for one more row of values."""
    result, after = torch.zeros_like(rewards), torch.zeros_like(rewards[0])
    for k in reversed(range(len(rewards))):
        runs = discount * (1.0 - ends[k])
        after = rewards[k] - values[k] + runs * (values[k + 1] + LAMBDA * after)
        result[k] = after
    return result


@torch.no_grad()
def evaluate(envs: Any, actor: nn.Module, normal: Normaliser, seed: int = 1_000_000) -> np.ndarray:
    """Return mean return and share of solved episodes, one for each environment, without noise.

    An episode is solved if the task is solved at its end.
    """
    observations, _ = envs.reset(seed=seed)
    runs, total = np.ones(envs.num_envs, bool), np.zeros(envs.num_envs)
    solved = np.zeros(envs.num_envs, bool)
    while runs.any():
        actions = actor(normal(observations)).numpy()
        observations, rewards, terminated, truncated, infos = envs.step(actions)
        total += runs * rewards
        ended = runs & (terminated | truncated)
        if ended.any():
            solved[ended] = (infos["final_info"]["solved"] & truncated)[ended]
            runs &= ~ended
    return np.array([total.mean(), solved.mean()])


class Curve:
    """Learning curve of a training, whose evaluations need no time.

    Args:
        options: Options of `add_options`.
        trial: Vector environment of the evaluations.

    Attributes:
        rows: Results of the evaluations.
    """

    def __init__(self, options: argparse.Namespace, trial: Any) -> None:
        self.rows: list[Row] = []
        self._options, self._trial, self._start = options, trial, self._now()

    def is_complete(self) -> bool:
        """Return whether the goal or the limit of time is reached."""
        time_spent = (self._now() - self._start)[int(self._options.cpu)]
        solved = self.rows[-1].solved if self.rows else 0.0
        return solved >= self._options.goal or time_spent >= 60.0 * self._options.minutes

    def evaluate(self, steps: int, actor: nn.Module, normal: Normaliser) -> None:
        """Add a row."""
        before = self._now()
        self.rows.append(Row(*before - self._start, steps, *evaluate(self._trial, actor, normal)))
        self._start += self._now() - before
        print(self.rows[-1].text(), flush=True)

    @staticmethod
    def _now() -> np.ndarray:
        return np.array([time.perf_counter(), time.process_time()])


def save(folder: Path, env: Any, actor: nn.Module, normal: Normaliser, rows: Sequence[Row]) -> None:
    """Write the learning curve, the network with its normalisation, and the policy for controllers.

    Controllers do not know the observations of some tasks, such as those of MyoSuite. Their policy
    is only written for PyTorch.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "curve.csv").open("w", newline="") as file:
        csv.writer(file).writerows([Row._fields, *rows])
    torch.save(actor.state_dict(), folder / "policy.pt")
    np.savez(folder / "normalisation.npz", mean=normal.mean, sd=normal.sd)
    try:
        policy = actor.state_dict()
        export_policy(env, policy, folder / "policy.json", mean=normal.mean, sd=normal.sd)
    except InputError as error:
        print(f"policy.json is not written: {error}")
