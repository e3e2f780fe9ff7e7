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
PYTHONFMU3_PLANT = """
from pythonfmu3 import Fmi3Causality, Fmi3Slave, Float64


class Joints(Fmi3Slave):
    def __init__(self, **options):
        super().__init__(**options)
        self.push, self.angles, self.rates = [0.0] * 4, [-0.5, 0.5], [0.0, 0.0]
        self.time, self.lever = 0.0, 0.1
        self.register_variable(Float64("time", causality=Fmi3Causality.independent))
        for name, values, causality in (
            ("push", self.push, Fmi3Causality.input),
            ("angle", self.angles, Fmi3Causality.output),
            ("rate", self.rates, Fmi3Causality.output),
        ):
            for k in range(len(values)):
                self.register_variable(Float64(
                    f"{name}{k}", causality=causality,
                    getter=lambda values=values, k=k: values[k],
                    setter=lambda value, values=values, k=k: values.__setitem__(k, value),
                ))

    def do_step(self, time, step):
        for k in range(2):
            self.rates[k] += step * self.lever * (self.push[2 * k] - self.push[2 * k + 1])
            self.angles[k] += step * self.rates[k]
        return True
"""


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


def ran(folder: Path, experiment: str, *settings: str) -> dict[str, np.ndarray]:
    """Run an experiment in a separate process, and return the results."""
    name = Path(experiment).stem
    command = [sys.executable, "-m", "cardsflow_fmu.cli", "run", experiment, "-o", name]
    done = subprocess.run(
        [*command, "--set", f"run.duration={SECONDS}", *settings],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    summary = json.loads((folder / name / "summary.json").read_text(encoding="utf-8"))
    assert summary["status"] == "complete"
    with (folder / name / "results.csv").open(newline="") as opened:
        rows = list(csv.DictReader(opened))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


def test_the_plant_of_pythonfmu_has_the_same_trajectory(exchange: Path) -> None:
    """It is the same robot in other coordinates, with the same integration method."""
    theirs = ran(exchange, "their_plant.toml")
    ours = simulate(Experiment.load(PLANAR_2R, {"run.duration": SECONDS}))
    for name in ("q.joint_1", "q.joint_2", "qd.joint_1", "qd.joint_2"):
        np.testing.assert_allclose(theirs[name], ours[name], rtol=0, atol=1e-12, err_msg=name)
    for k in range(1, 5):
        np.testing.assert_allclose(theirs[f"f.cable_{k}"], ours[f"f.cable_{k}"], atol=1e-10)


def test_a_plant_of_pythonfmu3_runs_to_the_end(tmp_path: Path) -> None:
    """Its angles are the sums of the recorded forces, in FMI 3.0."""
    pytest.importorskip("pythonfmu3", reason="needs the extra `interop`")
    (tmp_path / "joints.py").write_text(PYTHONFMU3_PLANT)
    command = [sys.executable, "-m", "pythonfmu3", "build", "-f", "joints.py"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    inputs = {f"f.cable_{k + 1}": f"push{k}" for k in range(4)}
    outputs = {
        f"{group}.joint_{k + 1}": f"{name}{k}"
        for group, name in (("q", "angle"), ("qd", "rate"))
        for k in range(2)
    }
    settings = [f"fmus.plant.path={tmp_path}/Joints.fmu", "run.accept=any"]
    settings += [
        f"fmus.plant.{side}={_inline(names)}"
        for side, names in (("inputs", inputs), ("outputs", outputs))
    ]
    rows = ran(tmp_path, str(PLANAR_2R), *(word for s in settings for word in ("--set", s)))
    f = np.column_stack([rows[f"f.cable_{k}"] for k in range(1, 5)])[:-1]
    rate = np.cumsum(1e-3 * 0.1 * (f[:, [0, 2]] - f[:, [1, 3]]), axis=0)
    q = np.array([-0.5, 0.5]) + np.cumsum(1e-3 * rate, axis=0)
    found = np.column_stack([rows["q.joint_1"], rows["q.joint_2"]])
    np.testing.assert_allclose(found[1:], q, rtol=0, atol=1e-12)


def _inline(names: dict[str, str]) -> str:
    """Return an inline table of TOML."""
    return "{" + ", ".join(f'"{port}" = "{name}"' for port, name in names.items()) + "}"


def test_the_controller_of_pythonfmu_controls_the_plant(exchange: Path) -> None:
    """The applied forces are the forces of its control law at the same tick."""
    rows, robot = ran(exchange, "their_controller.toml"), DartDynamics(planar_2r())
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
