"""Speed, as ratios within one run: `pytest tests/benchmarks -s`.

Results are printed and written to benchmarks.json. Only ratios within the same run are meaningful,
since absolute times depend on the machine.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.interleaved import interleaved, record
from support.robots.robots import PLANAR_2R, chain, planar_2r

from addin_sdfusion.robot import Robot
from sim_dart import MusclePaths, Plant

CHAIN_LIMIT, ARM_LIMIT = 1.8, 4.0
COMMAND_LIMITS = {"run": 1.2, "version": 0.15}  # in [s]


def test_muscle_paths(benchmark: Any) -> None:
    """Compute l and L of q for 60 muscles with 4 points on 20 joints."""
    paths = MusclePaths(chain())
    q = np.random.default_rng(0).uniform(-1, 1, 20)
    benchmark(paths.evaluate, q)
    seconds = interleaved({"evaluate": lambda: paths.evaluate(q)}, calls=2000)["evaluate"]
    record("muscle paths, 60 muscles of 4 points on 20 joints", us_per_call=seconds * 1e6)
    assert seconds <= 10e-6


@pytest.mark.parametrize(
    ("name", "robot", "limit"),
    [("two-link arm", planar_2r(), ARM_LIMIT), ("20-joint chain", chain(), CHAIN_LIMIT)],
    ids=["arm", "chain"],
)
def test_plant_step(benchmark: Any, name: str, robot: Robot, limit: float) -> None:
    """Compare a plant step with a plain DART step, on equal worlds from equal states."""
    pulled, bare = (Plant(robot, engine="dart") for _ in range(2))
    forces = np.array([muscle.f_min for muscle in robot.muscles])
    start = np.random.default_rng(0).uniform(-0.5, 0.5, len(robot.coordinates))
    calls = 200

    def blocks(plant: Plant, step: Callable[[], object]) -> Callable[[], object]:
        """Return a block of steps from a moving start, since DART skips resting bodies."""

        def block() -> None:
            plant.reset(start)
            for _ in range(calls):
                step()

        return block

    benchmark(lambda: pulled.step(forces))
    times = interleaved(
        {
            "plant": blocks(pulled, lambda: pulled.step(forces)),
            "world": blocks(bare, bare.world.step),
        },
        calls=1,
        rounds=100,
    )
    times = {name: seconds / calls for name, seconds in times.items()}
    ratio = times["plant"] / times["world"]
    record(
        f"plant step, {name}",
        ratio_to_world_step=ratio,
        plant_us=times["plant"] * 1e6,
        world_step_us=times["world"] * 1e6,
    )
    assert ratio <= limit


def test_whole_commands(tmp_path: Path) -> None:
    """Time until the prompt, with warm caches, in processor time of the command."""
    words = {
        "run": ["run", str(PLANAR_2R), "-q", "-o", str(tmp_path)],
        "version": ["--version"],
    }
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    environment["PYTHONPYCACHEPREFIX"] = str(tmp_path / "cache")
    best = dict.fromkeys(words, float("inf"))
    for _ in range(4):
        for name, given in words.items():
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            command = [sys.executable, "-m", "cardsflow_fmu.cli", *given]
            subprocess.run(command, stdout=subprocess.DEVNULL, env=environment, check=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            best[name] = min(best[name], spent)
    summary = json.loads((tmp_path / "summary.json").read_text())
    record(
        "commands until the prompt",
        **{f"{name}_s": seconds for name, seconds in best.items()},
        first_step_after_s=float(summary["first_step_after_s"]),
    )
    for name, limit in COMMAND_LIMITS.items():
        assert best[name] <= limit
