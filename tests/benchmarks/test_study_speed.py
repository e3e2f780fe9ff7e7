"""Studies: runs a second on one process and on two, and what a run costs beyond its simulation."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np
import pytest
from interleaved import record
from small_studies import small_study

from cardsflow_fmu.studies import run_study
from cardsflow_fmu.studies.crew import process_crew

RUNS = 200
MANY = """
[[vary]]
path = "controller.kp"
uniform = [500.0, 2000.0]
"""
SHORT = "[settings]\ncontroller.period = 0.01\nrun.step = 0.01\nrun.duration = 4.0\n"


def test_throughput(tmp_path: Path) -> None:
    """The processes are warm before the clock runs; the machine must be quiet to tell anything."""
    top = "count = {}\nseed = {}\nmetrics = ['tracking.rms', 'force.peak']"
    warm = small_study(tmp_path, MANY, top.format(8, 1), SHORT)
    study = small_study(tmp_path, MANY, top.format(RUNS, 2), SHORT)
    load = os.getloadavg()[0]
    times = {}
    for jobs in (1, 2):
        with process_crew(jobs) as crew:
            run_study(warm, crew=crew, output=tmp_path / f"warm_{jobs}")
            begin = time.perf_counter()
            run_study(study, crew=crew, output=tmp_path / f"{jobs}")
            times[jobs] = time.perf_counter() - begin
    record(
        "study_throughput",
        runs_per_s_1=RUNS / times[1],
        runs_per_s_2=RUNS / times[2],
        ratio=times[1] / times[2],
        load=load,
        cores=float(os.cpu_count() or 1),
    )


@pytest.mark.parametrize(("engine", "limit"), [("direct", 0.05), ("fmu", 0.3)])
def test_overhead(tmp_path: Path, engine: str, limit: float) -> None:
    """Reading, building and looking at the results, after the first runs of a process."""
    top = f"count = 24\nengine = '{engine}'\nmetrics = ['tracking.rms', 'force.peak', 'energy']"
    study = small_study(tmp_path, MANY, top, SHORT)
    result = run_study(study, jobs=1, output=tmp_path / "out")
    overheads = [outcome.overhead for _, outcome in result.rows()][4:]
    median = float(np.median(overheads))
    record(f"study_overhead_{engine}", median_s=median, least_s=min(overheads))
    assert median < limit
