"""Speed, as ratios within one run: `pytest tests/benchmarks -s`.

Results are printed and written to benchmarks.json. Only ratios within the same run are meaningful,
since absolute times depend on the machine.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.interleaved import interleaved, record
from support.robots.robots import PLANAR_2R, chain, planar_2r
from support.run_modes import RUN_MODES

from addin_sdfusion.robot import Robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.run import simulate
from sim_dart import MusclePaths, Plant

CHAIN_LIMIT, ARM_LIMIT = 1.8, 4.0


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


def test_cosimulation(benchmark: Any) -> None:
    """Compare three FMUs in the master with the same loop in Python."""
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 2.0})
    benchmark.pedantic(lambda: simulate(experiment), rounds=1)
    loops: dict[str, list[float]] = {"python": [], "direct": []}
    for _ in range(5):
        for through in ("python", "direct"):
            result = simulate(experiment, **RUN_MODES[through])  # type: ignore[arg-type]
            loops[through].append(result.summary["real_time_factor"])
    ratio = float(np.median(loops["direct"]) / np.median(loops["python"]))
    record(
        "co-simulated loop, two-link arm at 1 kHz",
        ratio_to_plain_python=ratio,
        real_time_factor=float(np.median(loops["python"])),
    )
    assert ratio <= 2.0


def test_whole_run(benchmark: Any, tmp_path: Path) -> None:
    """Run the example for 8 s at 1 kHz, and measure the time until the first step."""
    command = [sys.executable, "-m", "cardsflow_fmu.cli", "run", str(PLANAR_2R), "--json"]

    def run() -> dict[str, Any]:
        done = subprocess.run(
            [*command, "-o", str(tmp_path)], capture_output=True, text=True, check=True
        )
        summary: dict[str, Any] = json.loads(done.stdout)
        return summary

    run()  # warm caches
    summary = benchmark.pedantic(run, rounds=1)
    record(
        "cardsflow run examples/planar_2r",
        real_time_factor=float(summary["real_time_factor"]),
        first_step_after_s=float(summary["first_step_after_s"]),
    )
    assert summary["real_time_factor"] >= 5.0
    assert summary["first_step_after_s"] <= 4.0
