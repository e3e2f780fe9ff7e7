"""Steps of vector environments, compared with `Batch.step`: `test_environment_speed.py -s`."""

from __future__ import annotations

import time
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import SyncVectorEnv
from support.interleaved import interleaved, record

import cardsflow_fmu.gym  # noqa: F401  (registers the environments)
from sim_dart import Batch

N, CALLS, ROUNDS = 1024, 20, 30


@pytest.mark.parametrize("name", ["PlanarReach-v0", "PlanarPose-v0", "TrackFlower-v0"])
def test_overhead_of_environments_is_small(name: str) -> None:
    """The batch steps as many instances from the same states; the others start in a step."""
    envs: Any = gymnasium.make_vec(f"cardsflow/{name}", N, threads=1)
    envs.reset(seed=0)
    stepped, setup = envs.unwrapped.episodes.batch, envs.unwrapped.episodes.setup
    batch = Batch(setup.robot, N, setup.step, substeps=setup.substeps, threads=1)
    rng, ends = np.random.default_rng(0), []
    times: dict[str, list[float]] = {"environment": [], "batch": []}
    for _ in range(ROUNDS):
        for u in rng.uniform(-1.0, 1.0, (CALLS, *envs.action_space.shape)).astype("f4"):
            begin = time.perf_counter()
            flags = envs.step(u)[2]
            times["environment"].append(time.perf_counter() - begin)
            ends.append(flags.mean())
        x, commands = stepped.get_state(), stepped.commands.copy()
        for _ in range(CALLS):
            batch.set_state(x)
            moving = rng.random(N) >= np.mean(ends)
            begin = time.perf_counter()
            batch.step(commands, chosen=moving)
            times["batch"].append(time.perf_counter() - begin)
    of_environment, of_batch = (float(np.quantile(t, 0.25)) for t in times.values())
    overhead = of_environment / of_batch - 1.0
    figures = {"batch_ms": 1e3 * of_batch, "overhead": overhead, "ends": float(np.mean(ends))}
    record(f"environment {name}", **figures)
    assert overhead < 0.15


def test_vector_environment_is_faster_than_a_loop_over_environments() -> None:
    n, name = 64, "cardsflow/PlanarReach-v0"
    loop = SyncVectorEnv([lambda: gymnasium.make(name)] * n)
    ours: Any = gymnasium.make_vec(name, n, threads=1)
    actions = np.full(ours.action_space.shape, -0.9, np.float32)
    for envs in (loop, ours):
        envs.reset(seed=0)
    calls = {"ours": lambda: ours.step(actions), "loop": lambda: loop.step(actions)}
    times = interleaved(calls, calls=3)
    record("vector environment", loop_over_ours=times["loop"] / times["ours"])
    assert times["loop"] / times["ours"] > 10.0


@pytest.mark.parametrize("n", [1024, 4096])
def test_two_threads_share_the_steps(n: int) -> None:
    envs = {k: gymnasium.make_vec("cardsflow/TrackFlower-v0", n, threads=k) for k in (1, 2)}
    batches: dict[str, Any] = {str(k): e.unwrapped.episodes.batch for k, e in envs.items()}
    for batch in batches.values():
        batch.reset()
    u = np.full(batches["1"].commands.shape, 20.0)
    times = interleaved({k: lambda b=b: b.step(u) for k, b in batches.items()}, calls=2)
    record(f"two threads, {n} instances", one_over_two=times["1"] / times["2"])
    assert times["1"] / times["2"] > 1.8
