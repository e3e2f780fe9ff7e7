"""Example exchange: FMUs of PythonFMU as plant and as controller."""

from __future__ import annotations

import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support.robots.robots import EXAMPLES, PLANAR_2R, planar_2r

from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.run import simulate
from sim_dart import DartDynamics

pytestmark = pytest.mark.interop

SECONDS = 1.0


@pytest.fixture(scope="module")
def exchange(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the example's folder with both FMUs, built as its README specifies."""
    pytest.importorskip("pythonfmu", reason="needs the extra `interop`")
    folder = tmp_path_factory.mktemp("examples")
    for name in ("exchange", "planar_2r"):
        unwanted = shutil.ignore_patterns("results", "*.fmu")
        shutil.copytree(EXAMPLES / name, folder / name, ignore=unwanted)
    for files in (["two_link_arm.py"], ["pd_controller.py", "two_link_arm.py"]):
        command = [sys.executable, "-m", "pythonfmu", "build", "-f", *files]
        subprocess.run(command, cwd=folder / "exchange", check=True, capture_output=True)
    return folder / "exchange"


def ran(exchange: Path, name: str) -> dict[str, np.ndarray]:
    """Run one of its experiments in a separate process, and return the results."""
    command = [sys.executable, "-m", "cardsflow_fmu.cli", "run", f"{name}.toml", "-o", name]
    done = subprocess.run(
        [*command, "--set", f"run.duration={SECONDS}"],
        cwd=exchange,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    summary = json.loads((exchange / name / "summary.json").read_text(encoding="utf-8"))
    assert summary["status"] == "complete"
    with (exchange / name / "results.csv").open(newline="") as opened:
        rows = list(csv.DictReader(opened))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


def test_the_plant_of_pythonfmu_has_the_same_trajectory(exchange: Path) -> None:
    """It is the same robot in other coordinates, with the same integration method."""
    theirs = ran(exchange, "their_plant")
    ours = simulate(Experiment.load(PLANAR_2R, {"run.duration": SECONDS}))
    for name in ("q.joint_1", "q.joint_2", "qd.joint_1", "qd.joint_2"):
        np.testing.assert_allclose(theirs[name], ours[name], rtol=0, atol=1e-12, err_msg=name)
    for k in range(1, 5):
        np.testing.assert_allclose(theirs[f"f.cable_{k}"], ours[f"f.cable_{k}"], atol=1e-10)


def test_the_controller_of_pythonfmu_controls_the_plant(exchange: Path) -> None:
    """The applied forces are the forces of its control law at the same tick."""
    rows, robot = ran(exchange, "their_controller"), DartDynamics(planar_2r())
    q, qd, q_d, qd_d = (
        np.column_stack([rows[f"{group}.joint_{k}"] for k in (1, 2)])
        for group in ("q", "qd", "q_d", "qd_d")
    )
    forces = np.column_stack([rows[f"f.cable_{k}"] for k in range(1, 5)])
    mean = np.full(4, 30.0)
    for k in range(0, len(q) - 1, 10):
        arms = -robot.muscle_jacobian(q[k]).T
        torques = 100.0 * (q_d[k] - q[k]) + 5.0 * (qd_d[k] - qd[k])
        expected = mean + np.linalg.pinv(arms) @ (torques - arms @ mean)
        np.testing.assert_allclose(forces[k], np.clip(expected, 10.0, 100.0), atol=1e-9)
    assert np.abs(q - q_d).max() < 0.04
