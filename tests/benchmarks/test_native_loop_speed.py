"""Native control loops relative to real time: `test_native_loop_speed.py -s`.

The arm of the example uses its operational-space controller, at its period and at 1 kHz. Factors
are the best of many short blocks, measured in processor time of this thread, so that other programs
do not affect them.
"""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from support.interleaved import interleaved, record
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.external_fmu import without_missing_loads
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.signals.ports import load_signals
from cardsflow_fmu.models.native_loop import native_loop
from cardsflow_fmu.simulation.build import build
from sim_dart import Plant

MASTER_LIMIT, LOOP_LIMIT, THREADS_LIMIT = 100.0, 120.0, 1.8  # times real time; times one thread
INSTANTIATE_LIMIT = 5e-3  # in [s]
ENGINE_LIMIT = 2.0
STEPS = 12_800


def arm(period: float) -> Experiment:
    settings = {"controller.period": period, "run.duration": STEPS * 1e-3}
    return Experiment.load(EXAMPLES / "roboy_left_arm", settings)


class Blocks:
    """Timer of blocks of steps, which is called after each block."""

    def __init__(self) -> None:
        self._stamps = [(0, time.thread_time())]

    def __call__(self, done: int) -> None:
        self._stamps.append((done, time.thread_time()))

    def factor(self, step: float) -> float:
        """Return the real-time factor of the fastest block."""
        steps, seconds = np.diff(np.array(self._stamps), axis=0)[1:-2].T
        return float((steps * step / seconds).max())


@pytest.mark.parametrize("period", [0.005, 0.001])
def test_real_time_factors_of_master_and_loop_in_c(period: float, tmp_path: Path) -> None:
    experiment = arm(period)
    fmus = build(experiment, tmp_path, compute="c")
    parts = {
        name: FmuInstance(name, fmus[name], tmp_path / name)
        for name in ("plant", "reference", "controller")
    }
    run, loads = experiment.run, load_signals(experiment.robot)
    master = Master(
        list(parts.values()),
        without_missing_loads(experiment.wiring, experiment.fmus, parts.values(), loads),
        step=run.step,
        steps=run.steps,
        coupling=run.stepping,
        every={"controller": round(period / run.step)},
    )
    blocks = Blocks()
    recording = master.run(blocks)
    through_master = blocks.factor(run.step)
    in_c = Blocks()
    rows = native_loop(experiment).run(in_c).rows
    through_c = in_c.factor(run.step)
    assert recording.failure is None
    np.testing.assert_array_equal(rows, recording.rows)
    record(f"native arm, control every {period} s", master=through_master, loop_in_c=through_c)
    assert through_master >= MASTER_LIMIT
    assert through_c >= LOOP_LIMIT


def test_instantiation_time(tmp_path: Path) -> None:
    """The library is already loaded, like in a study."""
    fmus = build(arm(0.005), tmp_path, compute="c")
    best = {}
    for name in ("plant", "controller", "reference"):
        FmuInstance(name, fmus[name], tmp_path / name).close()
        times = []
        for _ in range(20):
            begin = time.thread_time()
            instance = FmuInstance(name, fmus[name], tmp_path / name)
            times.append(time.thread_time() - begin)
            instance.close()
        best[name] = min(times)
    record("instantiating a native FMU", **best)
    assert max(best.values()) < INSTANTIATE_LIMIT


def test_two_threads_of_closed_loops() -> None:
    """Each thread has separate models, and calls release the Python lock (GIL)."""
    experiment = arm(0.001)

    def steps(loop: Master) -> None:
        assert loop.run().failure is None

    steps(native_loop(experiment))
    with ThreadPoolExecutor(2) as pool:

        def one_thread() -> float:
            a, b = native_loop(experiment), native_loop(experiment)
            begin = time.perf_counter()
            steps(a)
            steps(b)
            return time.perf_counter() - begin

        def two_threads() -> float:
            a, b = native_loop(experiment), native_loop(experiment)
            begin = time.perf_counter()
            list(pool.map(steps, (a, b)))
            return time.perf_counter() - begin

        alone, together = zip(*((one_thread(), two_threads()) for _ in range(30)), strict=True)
    ratio = min(alone) / min(together)
    record("two threads of closed loops", ratio=ratio)
    assert ratio >= THREADS_LIMIT


def test_step_times_of_both_plant_engines() -> None:
    """Compare a step of a plant, called from Python, with both engines."""
    robot = arm(0.005).robot
    forces = np.array([muscle.f_min for muscle in robot.muscles])
    plants = {engine: Plant(robot, engine=engine) for engine in ("core", "dart")}  # type: ignore[arg-type]
    steps = {name: (lambda plant=plant: plant.step(forces)) for name, plant in plants.items()}
    times = interleaved(steps, calls=100, rounds=100)
    ratio = times["dart"] / times["core"]
    record("plant's engines", ratio=ratio, core_us=times["core"] * 1e6, dart_us=times["dart"] * 1e6)
    assert ratio >= ENGINE_LIMIT
