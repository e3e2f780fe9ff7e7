"""Runs in separate processes: equal tables, dead workers, killed parents, Dask."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from typing import Any, cast

import pytest
from support.cases import LONG
from support.deadly_runs import DEADLY, DeadlyExecutor
from support.small_studies import run_here, small_study, write_study

from cardsflow_fmu.studies import StudyError, run_study
from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.sampling import Run
from cardsflow_fmu.studies.execution.dispatch import dispatch
from cardsflow_fmu.studies.execution.worker import Job

MANY = """
[[vary]]
path = "controller.kp"
uniform = [500.0, 2000.0]
[[vary]]
path = "plant.mass_scale.*"
uniform = [0.8, 1.2]
"""
TWO_HUNDRED = "count = 200\nsampler = 'latin_hypercube'"
SECOND = "[settings]\ncontroller.period = 0.01\nrun.step = 0.01\nrun.duration = 2.0\n"
JOB = cast(Job, None)


def deadly(gains: Iterable[float]) -> list[Run]:
    return [Run(k, {}, {DEADLY: gain}, f"{k:024}") for k, gain in enumerate(gains)]


@pytest.mark.slow
def test_a_run_that_kills_its_worker_fails_and_the_others_continue() -> None:
    stored: dict[int, Outcome] = {}
    with closing(DeadlyExecutor(2)) as executor:
        runs = deadly([1.0, 2.0, -1.0, 3.0, 4.0, 5.0])
        dispatch(runs, JOB, executor, lambda run, outcome: stored.update({run.index: outcome}))
    assert sorted(stored) == list(range(6))
    assert [k for k, outcome in stored.items() if not outcome.complete] == [2]
    assert "its worker died 3 times" in str(stored[2].error)
    assert stored[5].metrics == {"force.peak": 5.0}


@LONG
def test_a_study_stops_if_every_run_kills_its_worker() -> None:
    with (
        closing(DeadlyExecutor(1)) as executor,
        pytest.raises(StudyError, match="every run kills its worker"),
    ):
        dispatch(deadly([-1.0] * 50), JOB, executor, lambda run, outcome: None)


@pytest.mark.slow
def test_processes_and_one_thread_write_equal_tables(tmp_path: Path) -> None:
    study = small_study(tmp_path, MANY, "count = 12")
    run_here(study, tmp_path / "one")
    run_study(study, jobs=2, output=tmp_path / "two")
    one, two = ((tmp_path / name / "table.csv").read_bytes() for name in ("one", "two"))
    assert one == two


@LONG
def test_tables_are_equal_for_one_worker_and_two_workers(tmp_path: Path) -> None:
    study = small_study(tmp_path, MANY, TWO_HUNDRED, SECOND)
    tables = []
    for jobs in (1, 2):
        run_study(study, jobs=jobs, output=tmp_path / str(jobs))
        tables.append((tmp_path / str(jobs) / "table.csv").read_bytes())
    assert tables[0] == tables[1]


@LONG
def test_a_study_killed_three_times_writes_the_same_table(tmp_path: Path) -> None:
    file = write_study(tmp_path, MANY, TWO_HUNDRED, SECOND)
    study = small_study(tmp_path, MANY, TWO_HUNDRED, SECOND)
    run_study(study, jobs=2, output=tmp_path / "whole")
    output = tmp_path / "out"
    stamps: dict[str, int] = {}
    for kill in range(3):
        process = started(file, output, resume=kill > 0)
        wait_for_runs(output, 40 * (kill + 1))
        workers = children(process.pid)
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        assert workers
        wait_for_end_of(workers)
        now = finished(output)
        assert stamps.items() <= now.items()
        assert len(now) > len(stamps)
        stamps = now
    assert started(file, output, resume=True).wait() == 0
    assert stamps.items() <= finished(output).items()
    assert len(finished(output)) == 200
    assert (output / "table.csv").read_bytes() == (tmp_path / "whole" / "table.csv").read_bytes()


@pytest.mark.extra("sweep")
@LONG
def test_a_study_continues_after_a_killed_dask_worker(tmp_path: Path) -> None:
    import distributed

    study = small_study(tmp_path, MANY, "count = 40", SECOND)
    killed: list[int] = []
    with (
        distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):

        def kill(done: int, total: int, failed: int) -> None:
            if done == 10 and not killed:
                killed.append(cluster.workers[0].process.pid)
                os.kill(killed[0], signal.SIGKILL)

        executor = client.get_executor(pure=False)
        run_study(study, executor, jobs=2, output=tmp_path / "dask", progress=kill)
    assert killed
    run_study(study, jobs=2, output=tmp_path / "own")
    own, dask = ((tmp_path / name / "table.csv").read_bytes() for name in ("own", "dask"))
    assert own == dask


def started(file: Path, output: Path, *, resume: bool) -> subprocess.Popen[Any]:
    """Start the command line in a separate process."""
    words = ["study", str(file), "-j", "2", "-o", str(output)]
    words += ["--resume"] if resume else []
    command = [sys.executable, "-m", "cardsflow_fmu.cli", *words]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL)


def finished(output: Path) -> dict[str, int]:
    """Return the modification time of each run's file."""
    return {file.name: file.stat().st_mtime_ns for file in (output / "runs").glob("*.json")}


def wait_for_runs(output: Path, count: int) -> None:
    end = time.monotonic() + 300.0
    while len(finished(output) if output.exists() else {}) < count:
        assert time.monotonic() < end
        time.sleep(0.02)


def children(parent: int) -> list[int]:
    """Return the child processes of a process."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == parent:
            found.append(int(folder.name))
    return found


def wait_for_end_of(processes: list[int]) -> None:
    """Wait until all processes have ended."""
    end = time.monotonic() + 300.0
    while any(is_alive(process) for process in processes):
        assert time.monotonic() < end
        time.sleep(0.05)


def is_alive(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"
