"""`cardsflow optimise`: from an experiment to a motion that a run follows, and wrong input."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.utils.csv_table import read_csv
from sim_dart import CoreDynamics

TOML = """
[robot]
path = "robot/planar_2r_bodies.xml"

[start]
q = [-0.5, 0.5]

[motion]
duration = 0.6
intervals = 20
goals = [{ q = [0.6, -0.4] }]

[reference]
type = "optimised"

[controller]
kp = 2000.0
kd = 90.0

[run]
coupling = "direct"
"""


@pytest.fixture
def cardsflow(capsys: pytest.CaptureFixture[str]) -> CommandLine:
    return CommandLine(capsys)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    shutil.copytree(PLANAR_2R / "robot", tmp_path / "robot")
    (tmp_path / "experiment.toml").write_text(TOML)
    return tmp_path / "experiment.toml"


def test_run_follows_the_optimised_motion(cardsflow: CommandLine, file: Path) -> None:
    assert f"compute it: `cardsflow optimise {file}`" in cardsflow.error_line("run", file)
    code, out, err = cardsflow("optimise", file)
    assert code == 0, err
    assert "iteration" in err
    assert "cost" in out
    names, rows = read_csv(file.parent / "motion.csv", what="motion", most=1_000_000)
    motion = dict(zip(names, rows.T, strict=True))
    assert motion["time"][-1] == 0.6
    ends = [[motion[f"{p}.joint_{k}"][row] for p in ("q", "qd") for k in (1, 2)] for row in (0, -1)]
    np.testing.assert_allclose(ends, [[-0.5, 0.5, 0, 0], [0.6, -0.4, 0, 0]], atol=1e-6)
    forces = np.array([motion[f"f.cable_{k}"] for k in (1, 2, 3, 4)])
    assert forces.min() >= 10.0
    summary = cardsflow.json("run", file)
    assert summary["tracking"]["rms"] < 5e-3
    reference = Experiment.load(file, {"controller.type": "operational_space"}).reference
    assert reference.space == "operational"
    dynamics = CoreDynamics(Experiment.load(file).robot)
    last = dynamics.task_position([0.6, -0.4])
    np.testing.assert_allclose(reference.curve.points[-1].q, last, atol=1e-6)
    assert (file.parent / "motion.svg").is_file()
    assert cardsflow.json("optimise", file)["status"] == "optimal"  # replaces its own files


def test_motion_that_begins_elsewhere_is_rejected(cardsflow: CommandLine, file: Path) -> None:
    assert cardsflow("optimise", file)[0] == 0
    line = cardsflow.error_line("run", file, "--set", "start.q=[0.2, 0.5]")
    assert "motion.csv begins at another pose than [start]; compute it again" in line


def test_infeasible_motion_names_constraint_node_and_forces(
    cardsflow: CommandLine, file: Path
) -> None:
    code, out, err = cardsflow("optimise", file, "--set", "motion.duration=0.1")
    assert (code, out) == (1, "")
    line = err.splitlines()[-1]
    assert line.startswith("cardsflow: no motion found: q.joint_1 must be 0.6, but is ")
    assert "at node 20 of 20 (t = 0.1 s)" in line
    assert not (file.parent / "motion.csv").exists()


@pytest.mark.parametrize(
    ("setting", "key", "message"),
    [
        ("motion.duration=0", "motion.duration", "must be positive"),
        ("motion.duration=[2.0,1.0]", "motion.duration", "must increase"),
        ("motion.duration=[1.0]", "motion.duration", "must be a number, or a list"),
        ("motion.duration=nan", "motion.duration", "must be positive and finite"),
        ("motion.intervals=1", "motion.intervals", "at least 2"),
        ("motion.intervals=2.5", "motion.intervals", "2.5"),
        ("motion.substeps=0", "motion.substeps", "at least 1"),
        ("motion.goals=[]", "motion.goals", "at least one table"),
        ("motion.goals=[{}]", "motion.goals[0].q", "missing; set q or y"),
        ("motion.goals=[{q={joint_3=1.0}}]", "motion.goals[0].q.joint_3", "did you mean"),
        ("motion.goals=[{q=[1.0]}]", "motion.goals[0].q", "must have 2 values"),
        ("motion.goals=[{y={hand=1.0}}]", "motion.goals[0].y.hand", "no task coordinate"),
        ("motion.goals=[{y=[1.0,2.9]}]", "motion.goals[0].y", "no configuration reaches"),
        ("motion.goals=[{q=[9.0,0.0]}]", "motion.goals[0].q.joint_1", "within the bounds"),
        ("motion.goals=[{time=0.7,q=[0,0]}]", "motion.goals[0].time", "within the duration"),
        ("motion.goals=[{time=0.1,q=[0,0]}]", "motion.goals[0].time", "multiple of an interval"),
        ("motion.goals=[{where=1}]", "motion.goals[0].where", "no key 'where'"),
        ("motion.cost={force=1.0}", "motion.cost.force", "did you mean 'forces'"),
        ("motion.cost={forces=-1.0}", "motion.cost.forces", "must not be negative"),
        ("motion.bounds.f_min=-1.0", "motion.bounds.f_min.cable_1", "cannot push"),
        ("motion.bounds.f_max=1.0", "motion.bounds.f_max.cable_1", "at least the minimum"),
        ("motion.bounds.q_max.joint_1=-0.6", "start.q.joint_1", "bounds -3.1"),
        ("motion.bounds.qd_max.joint_9=1.0", "motion.bounds.qd_max.joint_9", "did you mean"),
    ],
)
def test_wrong_input_is_one_line_with_the_key(
    cardsflow: CommandLine, file: Path, setting: str, key: str, message: str
) -> None:
    code, out, err = cardsflow("optimise", file, "-q", "--set", setting)
    assert (code, out) == (2, "")
    lines = err.splitlines()
    assert lines[0].startswith(f"cardsflow: {file}: {key}: ")
    assert message in lines[0]
    assert len(lines) == 1


def test_experiment_without_motion_is_rejected_with_an_example(cardsflow: CommandLine) -> None:
    assert "[motion]" not in (PLANAR_2R / "experiment.toml").read_text()
    line = cardsflow.error_line("optimise", PLANAR_2R, "-q")
    assert "motion: missing; for example: duration = 1.0" in line


def test_robot_rests_at_the_start_with_the_reference_rest(file: Path) -> None:
    experiment = Experiment.load(file, {"reference": {"type": "rest"}, "start.q": [0.1, 0.2]})
    assert {point.q for point in experiment.reference.curve.points} == {(0.1, 0.2)}
