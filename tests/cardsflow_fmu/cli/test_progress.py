"""Progress of long work: lines with the remaining time in a pipe, and callbacks of the API."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.robots import PLANAR_2R

from cardsflow_fmu.cli.terminal.messages import quiet_messages
from cardsflow_fmu.cli.terminal.progress import PERIOD, ProgressLines, show_progress
from cardsflow_fmu.simulation.excite import excite
from sim_dart.calibration.fit_progress import FitProgress
from sim_dart.calibration.recordings import Recording, Window


class Clock:
    """Clock that a test sets."""

    def __init__(self) -> None:
        self.time = 100.0

    def __call__(self) -> float:
        return self.time


def test_progress_in_a_pipe_is_one_line_per_10_s(capsys: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    lines = ProgressLines("excite", clock=clock)
    for second in range(1, 35):
        clock.time += 1.0
        lines.update(second, 100)
    assert capsys.readouterr().err.splitlines() == [
        "cardsflow: excite: 10%, 10 s elapsed, 1 min 30 s left",
        "cardsflow: excite: 20%, 20 s elapsed, 1 min 20 s left",
        "cardsflow: excite: 30%, 30 s elapsed, 1 min 10 s left",
    ]


def test_lines_are_printed_between_slow_updates(capsys: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    lines = ProgressLines("study", "runs", clock)
    clock.time += 1.2 * PERIOD
    lines.print_if_due()
    lines.update(1, 4, 1)
    clock.time += PERIOD
    lines.print_if_due()
    lines.print_if_due()
    assert capsys.readouterr().err.splitlines() == [
        "cardsflow: study: 12 s elapsed",
        "cardsflow: study: 1 of 4 runs, 1 failed, 22 s elapsed, 26 s left",
    ]


def test_progress_with_unknown_total_has_no_remaining_time(
    capsys: pytest.CaptureFixture[str],
) -> None:
    clock = Clock()
    lines = ProgressLines("run", "steps", clock)
    clock.time += 3700.0
    lines.update(500, 0)
    assert capsys.readouterr().err == "cardsflow: run: 500 steps, 1 h 1 min elapsed\n"


def test_short_work_prints_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    with show_progress("run", "steps") as update:
        update(1, 2)
    with quiet_messages(True), show_progress("run", "steps") as update:
        update(2, 2)
    assert capsys.readouterr().err == ""


def test_excite_reports_its_progress(tmp_path: Path) -> None:
    calls: list[tuple[int, int]] = []
    parameters = ["joints.*.damping"]
    excite(
        PLANAR_2R / "robot",
        parameters,
        tmp_path / "new",
        duration=5.0,
        progress=lambda done, total: calls.append((done, total)),
    )
    done, totals = zip(*calls, strict=True)
    assert len(set(totals)) == 1
    assert list(done) == [*range(round(0.6 * totals[0]) + 1), totals[0]]


def windows(rows: int) -> list[Window]:
    nothing = np.zeros((rows, 1))
    readings = Recording("", 1e-3, nothing, nothing, nothing, nothing)
    return [Window(readings, 0, nothing)]


def test_progress_of_a_calibration_matches_its_stages() -> None:
    calls: list[tuple[int, int]] = []
    work = FitProgress(
        lambda done, total: calls.append((done, total)), [windows(1), windows(10)], iterations=2
    )
    work.add_iteration()
    work.end_stage()  # one iteration earlier than expected
    for _ in range(3):
        work.add_iteration()
    work.end_stage()
    assert calls == [(0, 22), (1, 22), (1, 21), (11, 21), (21, 31), (31, 41), (31, 31)]


def test_stages_without_iterations_count_as_work() -> None:
    calls: list[tuple[int, int]] = []
    work = FitProgress(
        lambda done, total: calls.append((done, total)), [windows(1), windows(10)], iterations=2
    )
    work.end_stage()
    work.end_stage()
    assert calls == [(0, 22), (1, 21), (11, 11)]
