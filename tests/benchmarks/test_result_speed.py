"""Times for tables and figures, and the cost of streaming during a run."""

from __future__ import annotations

import tempfile
import time
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest
from support.interleaved import interleaved, record
from support.recorded import sinusoidal_result, with_columns
from support.robots.robots import EXAMPLES, PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.cosim.signals.ports import coordinate_signals, muscle_signals
from cardsflow_fmu.results import row_store
from cardsflow_fmu.results.folder import OutputFolder
from cardsflow_fmu.results.journal import Journal
from cardsflow_fmu.results.report.figures import plot
from cardsflow_fmu.results.run_data import ExperimentRunData
from cardsflow_fmu.ros.recording import write_recording
from cardsflow_fmu.simulation.open import OpenExperiment, open_experiment
from cardsflow_fmu.simulation.result import SystemResult
from cardsflow_fmu.utils.csv_table import csv_text

ROWS, COLUMNS = 30_000, 60


@pytest.fixture(scope="module")
def large() -> SystemResult:
    """Return 30 s at 1 kHz of a robot with 20 muscles. Noise is the worst case for file formats."""
    kinds = ("f", "l", "q", "q_d", "slack")
    names = ("time", *(f"{kinds[k % 5]}.s{k // 5}" for k in range(COLUMNS - 1)))
    rows = np.random.default_rng(0).normal(size=(ROWS, COLUMNS)).cumsum(axis=0)
    rows[:, 0] = 1e-3 * np.arange(ROWS)
    return SystemResult(names, rows, dict.fromkeys(names, "N"), {"status": "complete"})


def timed(call: object) -> float:
    """Return the processor time of a call, in [s], which other programs do not affect."""
    begin = time.process_time()
    call()  # type: ignore[operator]
    return time.process_time() - begin


def test_figure_takes_less_than_five_seconds(large: SystemResult, tmp_path: Path) -> None:
    seconds = {
        form: timed(lambda form=form: plot(large, tmp_path / f"all.{form}", columns=["*"]))
        for form in ("png", "svg", "pdf")
    }
    usual = timed(lambda: plot(large, tmp_path / "usual.png"))
    record("figures of 30,000 x 60", usual_png=usual, **seconds)
    assert max(usual, *seconds.values()) < 5.0


def test_streaming_costs_as_much_as_writing_at_the_end(tmp_path: Path) -> None:
    """The fastest loop writes every row immediately, or all rows at the end."""
    experiment = Experiment.load(PLANAR_2R, {"run.coupling": "direct"})
    loop = {"streamed": float("inf"), "kept": float("inf")}

    def opened() -> AbstractContextManager[OpenExperiment]:
        return open_experiment(experiment, tmp_path / "aside", None)

    def timed_run(name: str, system: OpenExperiment, journal: Journal | None = None) -> Recording:
        begin = time.perf_counter()
        recording = system.loop.run(None, None, None, journal)
        loop[name] = min(loop[name], (time.perf_counter() - begin) / 8.0)
        return recording

    def streamed() -> None:
        place = Path(tempfile.mkdtemp(dir=tmp_path))
        with OutputFolder(place) as folder, opened() as system, Journal(folder, {}) as journal:
            journal.begin(system.loop.names, system.loop.units, system.loop.count, {})
            timed_run("streamed", system, journal)

    def kept() -> None:
        with opened() as system:
            recording = timed_run("kept", system)
        (tmp_path / "kept.csv").write_text(csv_text(recording.names, recording.rows))

    best = interleaved({"streamed": streamed, "kept": kept}, calls=1, rounds=8)
    total, ratio = best["streamed"] / best["kept"], loop["streamed"] / loop["kept"]
    record("streaming a run", total_ratio=total, loop_ratio=ratio, step_us=1e3 * loop["kept"])
    assert total < 1.25  # also with other load on the machine


def test_large_table_is_filled_quickly(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compare rows in an anonymous file with rows in memory."""
    row = np.ones(COLUMNS)

    def fill(limit: int) -> None:
        monkeypatch.setattr(row_store, "IN_MEMORY", limit)
        store = row_store.RowStore(ROWS, COLUMNS, tmp_path)
        for k in range(ROWS):
            store.rows[k] = row
            if k % 512 == 0:
                store.release(k)

    best = interleaved({"file": lambda: fill(0), "memory": lambda: fill(2**40)}, calls=1, rounds=5)
    extra = 1e6 * (best["file"] - best["memory"]) / ROWS
    record("rows in a file", extra_us_a_row=extra)
    assert extra < 10.0


@pytest.mark.extra("ros2")
def test_eight_seconds_at_1_khz_are_recorded_in_two_seconds(tmp_path: Path) -> None:
    """Record all topics of the left arm of Roboy, with 11 muscles, as MCAP."""
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm")
    run = sinusoidal_result(experiment.robot, 8.0, 1e-3)
    robot = experiment.robot
    rates = coordinate_signals("qd", robot) + muscle_signals("l", robot)
    run = with_columns(run, {name: np.cos(run["time"]) for name in rates})
    recorded = ExperimentRunData(**vars(run), experiment=experiment)
    write_recording(recorded, tmp_path / "warm.mcap")
    seconds = timed(lambda: write_recording(recorded, tmp_path / "run.mcap"))
    size = (tmp_path / "run.mcap").stat().st_size / 2**20
    record("8 s at 1 kHz as MCAP", s=seconds, MiB=size)
    assert seconds < 2.0
