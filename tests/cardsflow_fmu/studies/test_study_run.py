"""Execution of studies: runs, files, resuming and the table."""

from __future__ import annotations

import csv
import errno
import json
import os
import random
import shlex
import tracemalloc
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import pytest
from support.cases import LONG
from support.command_line import CommandLine
from support.small_studies import KP, run_here, small_study, write_study

from addin_sdfusion.robot import InputError
from cardsflow_fmu.studies import StudyError, run_study
from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.sampling import Run
from cardsflow_fmu.studies.definition.study import Study
from cardsflow_fmu.studies.execution import run_store
from cardsflow_fmu.studies.execution.run_store import RunStore
from cardsflow_fmu.studies.run import repeat_run
from cardsflow_fmu.utils.folder_lock import lock_folder

BOUNDS = """
[[vary]]
path = "muscles.cable_1.f_min"
values = [10.0, 200.0, 20.0]
"""


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "table.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


def summary(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return content


def stamps(folder: Path) -> dict[str, int]:
    return {file.name: file.stat().st_mtime_ns for file in (folder / "runs").iterdir()}


class Counting(Executor):
    """Executor that counts submitted runs and is interrupted after a number of runs."""

    def __init__(self, limit: int = 10**9) -> None:
        self.submitted: list[str] = []
        self.limit = limit

    def submit(self, run: Any, job: Any, settings: Any) -> Future[Any]:  # type: ignore[override]
        """Execute a run in this thread."""
        if len(self.submitted) == self.limit:
            raise KeyboardInterrupt
        self.submitted.append(json.dumps(settings))
        future: Future[Any] = Future()
        future.set_result(run(job, settings))
        return future


def runs_of(study: Study, output: Path, **options: Any) -> int:
    """Execute a study and return the number of its runs."""
    executor = Counting()
    run_study(study, executor, jobs=1, output=output, **options)
    return len(executor.submitted)


@pytest.mark.slow
def test_a_study_writes_one_row_per_run_in_order(tmp_path: Path) -> None:
    result = run_here(small_study(tmp_path), tmp_path / "out")
    rows = table(tmp_path / "out")
    assert [int(row["run"]) for row in rows] == list(range(6))
    assert [float(row["controller.kp"]) for row in rows] == [1000.0 + 200.0 * k for k in range(6)]
    assert {row["status"] for row in rows} == {"complete"}
    assert result.summary["runs"] == 6
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "runs",
        "table.csv",
        "table.units.json",
        "summary.json",
        "report.html",
    }


@pytest.mark.slow
def test_the_command_of_a_run_repeats_it_exactly(tmp_path: Path, cardsflow: CommandLine) -> None:
    """The command of the worst case reproduces its value exactly."""
    result = run_here(small_study(tmp_path), tmp_path / "out")
    worst = result.summary["worst"]["tracking.rms"][0]
    words = shlex.split(worst["command"])
    assert words[0] == "cardsflow"
    words[-1] = str(tmp_path / "again")
    again = cardsflow.json(*words[1:])
    assert again["tracking"]["rms"] == worst["value"]
    assert float(table(tmp_path / "out")[worst["run"]]["tracking.rms"]) == worst["value"]


def test_a_run_with_an_invalid_robot_is_a_failed_row(tmp_path: Path) -> None:
    result = run_here(small_study(tmp_path, BOUNDS), tmp_path / "out")
    first, second, third = table(tmp_path / "out")
    assert (first["status"], second["status"], third["status"]) == (
        "complete",
        "failed",
        "complete",
    )
    assert "f_min must be at most f_max, not 200.0 N with f_max 100.0 N" in second["error"]
    assert second["force.peak"] == ""
    assert result.summary["failed"] == 1
    assert "f_min must be at most f_max" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.slow
def test_resuming_executes_only_missing_runs(tmp_path: Path) -> None:
    study, output = small_study(tmp_path), tmp_path / "out"
    with pytest.raises(StudyError, match="interrupted; 4 of 6 runs are complete; use --resume"):
        run_study(study, Counting(limit=4), jobs=1, output=output)
    before = stamps(output)
    assert runs_of(study, output, resume=True) == 2
    assert len(before) == 4
    assert before.items() <= stamps(output).items()
    run_here(study, tmp_path / "whole")
    assert (output / "table.csv").read_bytes() == (tmp_path / "whole" / "table.csv").read_bytes()


@pytest.mark.slow
def test_runs_with_damaged_files_are_repeated(tmp_path: Path) -> None:
    study, output = small_study(tmp_path), tmp_path / "out"
    run_here(study, output)
    good = (output / "table.csv").read_bytes()
    one, two, three, *_ = sorted((output / "runs").iterdir())
    one.write_text(one.read_text()[:50])
    two.write_text(two.read_text().replace('"error": null', '"error": "none"'))
    three.write_bytes(b"")
    assert runs_of(study, output, resume=True) == 3
    assert (output / "table.csv").read_bytes() == good


@pytest.mark.parametrize(
    "change", [{"error": 3}, {"metrics": None}, {"metrics": {"a": "b"}}, {"x": 1}]
)
def test_a_run_with_invalid_types_is_ignored(tmp_path: Path, change: dict[str, object]) -> None:
    """A valid checksum is not sufficient."""
    store, run = RunStore(tmp_path), Run(0, {}, {"controller.kp": 1.0}, "abc")
    (tmp_path / "runs").mkdir()
    store.write(run, Outcome({"tracking.rms": 0.1}))
    assert store.read(run) is not None
    file = tmp_path / "runs/abc.json"
    content = json.loads(file.read_text())
    del content["check"]
    content |= change
    if "x" in change:
        del content["error"]
    file.write_text(json.dumps(content | {"check": run_store._check(content)}))
    assert store.read(run) is None
    assert store.settings("") == []


@pytest.mark.slow
def test_equal_runs_are_executed_once(tmp_path: Path) -> None:
    text = '[[vary]]\npath = "controller.kp"\nvalues = [1000.0, 1000.0, 1500.0]\n'
    assert runs_of(small_study(tmp_path, text), tmp_path / "out") == 2
    assert len(table(tmp_path / "out")) == 3


@pytest.mark.slow
def test_existing_runs_are_not_overwritten_by_default(tmp_path: Path) -> None:
    study = small_study(tmp_path)
    run_here(study, tmp_path / "out")
    with pytest.raises(InputError, match="--resume"):
        run_here(study, tmp_path / "out")


@pytest.mark.slow
def test_a_locked_folder_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    with (
        lock_folder(tmp_path / "out", "study"),
        pytest.raises(InputError, match=f"study of process {os.getpid()} on .* since "),
    ):
        run_here(small_study(tmp_path), tmp_path / "out")
    run_here(small_study(tmp_path), tmp_path / "out")


@pytest.mark.slow
def test_a_study_is_resumed_after_a_full_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study, output = small_study(tmp_path), tmp_path / "out"
    write, left = Path.write_bytes, [3]

    def full(path: Path, content: bytes) -> int:
        left[0] -= 1
        if left[0] < 0:
            write(path, content[:20])
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(StudyError, match=r"No space left on device.*3 of 6 runs.*--resume"):
        run_here(study, output)
    assert all(name.endswith(".json") and name[0] != "." for name in stamps(output))
    monkeypatch.undo()
    before = stamps(output)
    run_here(study, output, resume=True)
    assert len(before) == 3
    assert before.items() <= stamps(output).items()
    assert len(table(output)) == 6


def test_a_folder_instead_of_a_run_file_is_reported(tmp_path: Path) -> None:
    store = RunStore(tmp_path)
    (tmp_path / "runs/ab.json").mkdir(parents=True)
    with pytest.raises(StudyError, match=r"cannot be written: Is a directory$"):
        store.write(Run(0, {}, {}, "ab"), Outcome({}, None, 0.0, 0.0))


def test_a_read_only_folder_is_rejected(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        run_here(small_study(tmp_path), tmp_path / "file" / "out")


@pytest.mark.slow
def test_a_changed_experiment_starts_new_runs(tmp_path: Path) -> None:
    study, output = small_study(tmp_path), tmp_path / "out"
    run_here(study, output)
    assert "other_runs" not in summary(output)
    more = small_study(tmp_path, short=study_text(duration=0.3))
    assert runs_of(more, output, resume=True) == 6
    assert summary(output)["other_runs"] == 6


def study_text(duration: float) -> str:
    return f"[settings]\ncontroller.period = 0.01\nrun.step = 0.01\nrun.duration = {duration}\n"


@pytest.mark.slow
def test_only_repeats_one_run(tmp_path: Path) -> None:
    study = small_study(tmp_path)
    result = run_here(study, tmp_path / "out")
    run, outcome = list(result.rows())[2]
    command, again = repeat_run(study, run.hash[:8], tmp_path / "out")
    assert again.metrics == outcome.metrics
    assert "controller.kp=1400.0" in command
    with pytest.raises(InputError, match="no run has a hash"):
        repeat_run(study, "fffffff", tmp_path / "out")


def test_progress_reports_all_runs(tmp_path: Path) -> None:
    seen: list[tuple[int, int, int]] = []
    run_here(
        small_study(tmp_path, BOUNDS), tmp_path / "out", progress=lambda *now: seen.append(now)
    )
    assert seen[-1] == (3, 3, 1)
    assert [done for done, _, _ in seen] == [1, 2, 3]


@pytest.mark.slow
def test_the_command_line_rejects_invalid_options(tmp_path: Path, cardsflow: CommandLine) -> None:
    study = small_study(tmp_path)
    run_here(study, tmp_path / "out")
    words = "study", study.file, "-o", tmp_path / "out"
    assert "--resume" in cardsflow.error_line(*words)
    cardsflow.error_line("study", tmp_path / "nothing.toml")
    cardsflow.error_line("study", study.file, "-o", tmp_path / "new", "-j", 0)
    cardsflow.error_line(*words, "--only", "zz")
    first = table(tmp_path / "out")[0]
    printed = cardsflow.json(*words, "--only", first["hash"][:10])
    assert printed["metrics"]["tracking.rms"] == float(first["tracking.rms"])


class Instant(Executor):
    """Executor that completes every run immediately with random metrics."""

    def submit(self, function: Any, /, *arguments: Any, **named: Any) -> Future[Any]:
        future: Future[Any] = Future()
        metrics = {f"force.peak.cable_{k}": random.random() for k in (1, 2, 3, 4)}
        future.set_result(Outcome(metrics, None, 0.1, 0.1))
        return future


@pytest.mark.slow
def test_a_study_with_only_failed_runs_reports_the_reason(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    file = write_study(tmp_path, "[[vary]]\npath = 'controller.kp'\nvalues = [-1.0, -2.0]\n")
    code, text, _ = cardsflow("study", file, "-j", 1)
    assert code == 1
    assert "2 runs, 2 failed" in text
    assert "kp: must be above 0, not -1.0" in text


@pytest.mark.parametrize("prefix", ["", "*", "../x", "zz", "abcdef"])
def test_only_requires_the_first_digits_of_a_hash(
    tmp_path: Path, cardsflow: CommandLine, prefix: str
) -> None:
    assert "hash" in cardsflow.error_line("study", write_study(tmp_path), "--only", prefix)
    assert not (tmp_path / "results").exists()


def test_too_many_workers_are_rejected(tmp_path: Path, cardsflow: CommandLine) -> None:
    line = cardsflow.error_line("study", write_study(tmp_path), "-j", "99999999999999999999")
    assert "jobs: must be at most 1024" in line


def test_zero_workers_are_rejected(tmp_path: Path, cardsflow: CommandLine) -> None:
    file = write_study(tmp_path)
    assert "must be at least 1, not 0" in cardsflow.error_line("study", file, "-j", "0")


@LONG
def test_memory_does_not_grow_with_the_runs(tmp_path: Path) -> None:
    """Ten thousand rows require less than 20 MB; their numbers and hashes require 5 MB."""
    text = '[[vary]]\npath = "controller.kp"\nuniform = [1.0, 2.0]\n'
    peaks = []
    for count in (100, 10_000):
        study = small_study(tmp_path, text, f"count = {count}\nmetrics = ['force.peak.*']")
        tracemalloc.start()
        run_study(study, Instant(), jobs=2, output=tmp_path / str(count))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert len(table(tmp_path / "10000")) == 10_000
    assert peaks[1] - peaks[0] < 20e6


@pytest.mark.slow
def test_names_are_escaped_in_the_report(tmp_path: Path) -> None:
    """In Matplotlib dollar signs begin formulas, and an incomplete formula is an error."""
    name = "<img src=x onerror=alert(1)>$\\\\frac{$"
    result = run_here(small_study(tmp_path, KP + f'name = "{name}"\n'), tmp_path / "out")
    text = result.files["report.html"].read_text()
    assert "<img" not in text
    assert "&lt;img src=x" in text


def test_formulas_are_escaped_in_the_table(tmp_path: Path) -> None:
    text = """
[[vary]]
name = "=HYPERLINK(1)"
path = "controller.type"
values = ["@SUM(1)", "joint_space"]
"""
    result = run_here(small_study(tmp_path, text), tmp_path / "out")
    with result.files["table.csv"].open(newline="") as stream:
        header, first, second = csv.reader(stream)
    assert header[2] == "'=HYPERLINK(1)"
    assert (first[2], second[2]) == ("'@SUM(1)", "joint_space")
    assert not [cell for cell in (*header, *first, *second) if cell[:1] in tuple("=+@")]
