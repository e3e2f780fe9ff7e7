"""The FMPy script computes the trajectories of `run`, with the plant and with hardware."""

from __future__ import annotations

import ast
import csv
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.fmu.bare_environment import BareEnvironment
from support.robots.robots import EXAMPLES, PLANAR_2R

from cardsflow_fmu import Experiment, Result, build
from cardsflow_fmu.simulation.run import simulate

SCRIPT = EXAMPLES / "fmpy_script/cosimulate.py"
SHORT = {"run.duration": 0.2}


def read_rows(file: Path) -> dict[str, np.ndarray]:
    with file.open(newline="") as opened:
        rows = list(csv.DictReader(opened))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def cosimulated(fmus: Path, *robot: str, **variables: str) -> dict[str, np.ndarray]:
    """Run the script in a process and return the columns that it writes."""
    file = fmus / "results.csv"
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(fmus), str(file), *robot],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return read_rows(file)


def require_equal(rows: dict[str, np.ndarray], result: Result) -> None:
    """Check that common columns are equal bit for bit, except the computing time of ticks."""
    common = (set(rows) & set(result.names)) - {"solve_time"}
    assert len(common) > 18
    assert {name.split(".")[0] for name in common} >= {"q", "qd", "l"}
    for name in common:
        np.testing.assert_array_equal(rows[name], result[name], err_msg=name)


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("example", "settings"),
    [
        ("roboy_left_arm", {}),
        ("planar_2r", {"controller.period": 0.01}),
        ("pick_up", {}),
        ("hill_arm", {}),
        ("planar_2r", {}),
    ],
    ids=str,
)
def test_script_steps_like_run(example: str, settings: dict[str, Any], tmp_path: Path) -> None:
    """Examples include tasks, muscle laws and a world in Python."""
    experiment = Experiment.load(EXAMPLES / example, SHORT | settings)
    build(experiment, tmp_path)
    require_equal(cosimulated(tmp_path), simulate(experiment))


@pytest.fixture
def device() -> Iterator[str]:
    """Start `cardsflow device` with the two-link arm and yield its address."""
    command = [sys.executable, "-m", "cardsflow_fmu.cli", "device", str(PLANAR_2R)]
    process = subprocess.Popen(
        [*command, "--listen", "udp://127.0.0.1:0"],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        assert process.stdout is not None
        found = re.search(r"udp://\S+", process.stdout.readline())
        assert found is not None
        yield found[0]
    finally:
        process.send_signal(signal.SIGINT)
        said, _ = process.communicate(timeout=600)
    assert "safe: stopped on request" in said


@pytest.mark.slow
def test_same_script_runs_hardware(device: str, tmp_path: Path) -> None:
    """In lockstep, hardware is a simulation that is connected by a socket."""
    simulated = Experiment.load(PLANAR_2R, SHORT)
    lockstep = SHORT | {"hardware.mode": "lockstep", "hardware.ramp_in": 0.0}
    lockstep["hardware.timeout"] = 60.0
    build(Experiment.load(PLANAR_2R, lockstep), tmp_path)
    rows = cosimulated(tmp_path, "hardware", CARDSFLOW_HARDWARE_LINK=device)
    require_equal(rows, simulate(simulated))
    assert rows["missed"][-1] == 0


@pytest.mark.interop
def test_script_runs_without_this_package(tmp_path: Path) -> None:
    experiment = Experiment.load(PLANAR_2R, SHORT)
    build(experiment, tmp_path / "fmus")
    bare = BareEnvironment(tmp_path / "venv", "fmpy", "numpy", "lxml")
    bare.run([str(SCRIPT), str(tmp_path / "fmus"), str(tmp_path / "results.csv")])
    require_equal(read_rows(tmp_path / "results.csv"), simulate(experiment))


def test_script_imports_fmpy_and_the_standard_library() -> None:
    tree = ast.parse(SCRIPT.read_text(encoding="utf-8"))
    named = {a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names}
    named |= {str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    others = {name.split(".")[0] for name in named} - sys.stdlib_module_names
    assert others == {"fmpy"}
