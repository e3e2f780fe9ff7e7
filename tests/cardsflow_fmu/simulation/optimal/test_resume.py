"""`cardsflow optimise --resume`, Ctrl-C, and the replay of a motion."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from support.command_line import CommandLine
from support.robots.slider import slider_file

from cardsflow_fmu.cli import study
from cardsflow_fmu.simulation.optimal.files import write_motion_files
from cardsflow_fmu.simulation.optimal.optimise import load_for_motion, optimise
from controllers.optimal.sqp import Progress


@pytest.fixture
def interrupt_at(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Send SIGINT as Ctrl-C does, after this number of reports; empty: never."""
    reports: list[int] = []

    def report(_self: object, _own: Progress, _substeps: int) -> None:
        if reports:
            reports[0] -= 1
            if reports[0] == 0:
                os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(study._Iterations, "__call__", report)
    return reports


def test_resumed_motion_is_optimal_at_once(cardsflow: CommandLine, file: Path) -> None:
    """Also if the nodes lie between the rows of the file, as with a free duration."""
    own = ("optimise", file, "--set", "motion.duration=[0.3,1.0]", "--set", "motion.cost.time=100")
    first = cardsflow.json(*own)
    again = cardsflow.json(*own, "--resume", "--html", file.parent / "motion.html")
    assert again["iterations"] <= 2
    assert again["cost"] == pytest.approx(first["cost"], rel=1e-7)
    assert again["files"][-1].endswith("motion.html")
    page = (file.parent / "motion.html").read_text()
    assert all(word in page for word in ("Replay", "convergence", "Active bounds", "Iterations"))
    changed = {"motion.intervals": 30, "motion.goals": [{"q": [0.2, 0.1]}]}
    experiment = load_for_motion(file, changed)
    resumed = optimise(experiment, resume=file.parent / "motion.csv").solution.cost
    assert resumed == pytest.approx(optimise(experiment).solution.cost, rel=1e-6)


@pytest.mark.parametrize(("intervals", "reports"), [(20, 12), (100, 11)])
def test_interrupted_motion_is_kept_and_continued(
    cardsflow: CommandLine, file: Path, interrupt_at: list[int], intervals: int, reports: int
) -> None:
    """Before and after the first solution, whose substeps are then refined."""
    own = ("optimise", file, "--set", f"motion.intervals={intervals}")
    best = optimise(load_for_motion(file, {"motion.intervals": intervals})).solution.cost
    interrupt_at[:] = [reports]
    code, out, _ = cardsflow(*own)
    assert code == 1
    assert out.startswith("warning     interrupted: the motion ")
    assert out.splitlines()[0].endswith("; continue with --resume")
    interrupt_at.clear()
    resumed = cardsflow.json(*own, "--resume")
    assert resumed["status"] == "optimal"
    assert resumed["cost"] == pytest.approx(best, rel=1e-6)


def test_slow_iterations_name_faster_settings_once(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = study._Iterations(load_for_motion(file))
    for k in range(4):
        rows(Progress(k, 1.0, 0.5, 1.0, 5.0 * k), 1)
    assert capsys.readouterr().err.count("set fewer motion.intervals;") == 1


def test_interruption_before_the_first_motion_writes_no_file(
    cardsflow: CommandLine, file: Path, interrupt_at: list[int]
) -> None:
    interrupt_at[:] = [2]
    assert cardsflow.error_line("optimise", file, code=130) == "cardsflow: interrupted\n"
    assert not (file.parent / "motion.csv").exists()


def test_motion_that_cannot_be_resumed_is_one_line(
    cardsflow: CommandLine, file: Path, tmp_path: Path
) -> None:
    line = cardsflow.error_line("optimise", file, "--resume", "-q")
    assert f"{file.parent / 'motion.csv'}: does not exist; optimise without --resume" in line
    (tmp_path / "slider").mkdir()
    slider = slider_file(tmp_path / "slider")
    write_motion_files(optimise(load_for_motion(slider)), file.parent / "motion.csv")
    line = cardsflow.error_line("optimise", file, "--resume", "-q")
    assert "has no column 'q.joint_1', so it belongs to another robot" in line
