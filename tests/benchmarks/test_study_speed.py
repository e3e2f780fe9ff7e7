"""Throughput of studies with one and two processes, and overhead of a run.

The limits apply to an idle machine and are only checked there:

    pytest -n 0 -s tests/benchmarks/test_study_speed.py
"""

from __future__ import annotations

import os
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from support.interleaved import record
from support.small_studies import small_study

from cardsflow_fmu.studies import run_study
from cardsflow_fmu.studies.execution.executors import process_executor

RUNS, ROUNDS = 200, 2
QUIET = 0.5
TWO_STEPS = "[settings]\ncontroller.period = 0.01\nrun.step = 0.01\nrun.duration = 0.02\n"
TOP = "count = {}\nseed = {}\nmetrics = ['tracking.rms', 'force.peak']"
MANY = """
[[vary]]
path = "controller.kp"
uniform = [500.0, 2000.0]
"""
SHORT = "[settings]\ncontroller.period = 0.01\nrun.step = 0.01\nrun.duration = 4.0\n"


def test_throughput(tmp_path: Path) -> None:
    """Compare 200 runs with one and two processes; the ratio requires an idle machine.

    The processes are started before the measurement. The work of the main process per run limits
    the ratio on two cores, and can also be measured on a busy machine.
    """
    load = os.getloadavg()[0]
    studies = [
        small_study(tmp_path, MANY, TOP.format(RUNS // ROUNDS, seed), SHORT)
        for seed in range(ROUNDS + 1)
    ]
    times, own = dict.fromkeys((1, 2), 0.0), 0.0
    with process_executor(1) as one, process_executor(2) as two:
        for k, study in enumerate(studies):
            for jobs, executor in ((1, one), (2, two)):
                begin, cpu = time.perf_counter(), time.process_time()
                run_study(study, executor=executor, output=tmp_path / f"{jobs}_{k}")
                if k > 0:
                    times[jobs] += time.perf_counter() - begin
                    own += time.process_time() - cpu
    ratio = times[1] / times[2]
    record(
        "study_throughput",
        runs_per_s_1=RUNS / times[1],
        runs_per_s_2=RUNS / times[2],
        ratio=ratio,
        own_cpu_per_run_ms=1e3 * own / (2 * RUNS),
        load=load,
        cores=float(os.cpu_count() or 1),
    )
    if load < QUIET and (os.cpu_count() or 1) >= 2:
        assert ratio >= 1.7


def test_overhead(tmp_path: Path) -> None:
    """Measure reading, building and evaluation of runs, after the first runs of a process."""
    load = os.getloadavg()[0]
    top = "count = 24\nmetrics = ['tracking.rms', 'force.peak', 'energy']"
    study = small_study(tmp_path, MANY, top, SHORT)
    result = run_study(study, jobs=1, output=tmp_path / "out")
    overheads = [outcome.overhead for _, outcome in result.rows()][4:]
    median = float(np.median(overheads))
    record("study_overhead", median_s=median, least_s=min(overheads), load=load)
    if load < QUIET:
        assert median < 0.05


def test_overhead_in_processor_time(tmp_path: Path) -> None:
    """Measure the processor time of runs with two steps, also on a busy machine."""
    study = small_study(tmp_path, MANY, TOP.format(40, 1), TWO_STEPS)
    with ThreadPoolExecutor(1) as executor:
        run_study(study, executor, jobs=1, output=tmp_path / "warm")
        begin = time.process_time()
        run_study(study, executor, jobs=1, output=tmp_path / "out")
        each = (time.process_time() - begin) / 40
    record("study_overhead_cpu", each_s=each)
    assert each < 0.05
