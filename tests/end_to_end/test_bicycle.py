"""Controllers of robots with closed loops: legs on a bicycle, and a five-bar linkage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import CommandLine
from support.experiments import write_experiment
from support.robots.loops import five_bar, four_bar
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError, Robot, check, read_robot, write_sdf
from cardsflow_fmu import Experiment, run
from sim_dart import CoreDynamics

BICYCLE = EXAMPLES / "bicycle"
SHORT = {"run.duration": 0.3}


def largest_gap(robot: Robot, rows: np.ndarray) -> float:
    """Return the largest gap of a loop closure at some poses of a run."""
    core, count, gaps = CoreDynamics(robot)._core, 5 * len(robot.loops), []
    for q in rows:
        core.move(core.handle, np.ascontiguousarray(q).tobytes())
        core.closures(core.handle, np.zeros(len(q)).tobytes())
        gaps.append(np.abs(core.array("closure_gap", count)).max())
    return float(max(gaps))


def positions(experiment: Experiment, found: Any) -> np.ndarray:
    return np.column_stack([found[f"q.{c.name}"] for c in experiment.robot.coordinates])


def test_robot_has_no_findings() -> None:
    assert check(read_robot(BICYCLE / "robot")) == []


@pytest.mark.slow
def test_legs_turn_the_pedals_three_times(tmp_path: Path) -> None:
    experiment = Experiment.load(BICYCLE)
    found = run(experiment, tmp_path)
    assert found.summary["infeasible_ticks"] == 0
    assert found.summary["tracking"]["max"] < 1e-3
    q = positions(experiment, found)
    assert q[-1, 0] == pytest.approx(6.0 * np.pi, abs=1e-3)
    assert largest_gap(experiment.robot, q[::100]) < 1e-4


def tip_experiment(folder: Path, **more: Any) -> Experiment:
    """Create an experiment that moves the tip of a five-bar linkage to a point and back."""
    robot = five_bar()
    start = CoreDynamics(robot).task_position([c.initial for c in robot.coordinates])
    points = "".join(
        f"[[reference.points]]\ntime = {time}\n[reference.points.y]\n"
        f'"tip_point.x" = {start[0] + dx}\n"tip_point.z" = {start[1] + dz}\n'
        for time, dx, dz in ((0.0, 0.0, 0.0), (0.5, 0.04, -0.05), (1.0, 0.0, 0.0))
    )
    text = (
        'reference.spline = "quintic"\n'
        "plant.step = 0.001\nrun = { step = 0.001, duration = 1.0 }\n"
        'controller = { type = "operational_space", kp = 900.0, kd = 60.0, period = 0.002 }\n'
    )
    return Experiment.load(write_experiment(robot, folder, text + points), more)


@pytest.mark.slow
@pytest.mark.native
def test_tip_of_a_five_bar_linkage_tracks_in_operational_space(tmp_path: Path) -> None:
    experiment = tip_experiment(tmp_path)
    found = run(experiment, tmp_path / "out")
    assert found.summary["infeasible_ticks"] == 0
    assert found.summary["tracking"]["max"] < 2e-4  # [m]


@pytest.mark.slow
def test_init_writes_a_motion_of_independent_coordinates(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_sdf(five_bar(), tmp_path / "robot")
    CommandLine(capsys)("init", tmp_path / "robot", "-o", tmp_path / "made")
    text = (tmp_path / "made/experiment.toml").read_text()
    assert text.count("dependent.") == 2
    found = run(Experiment.load(tmp_path / "made"), tmp_path / "out")
    assert found.summary["infeasible_ticks"] == 0
    assert found.summary["tracking"]["max"] < 1e-3


@pytest.mark.slow
def test_published_legs_on_pedals_track(
    shared: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = shared / "robots/cardsflow/biking_legs"
    CommandLine(capsys)("init", robot, "-o", tmp_path / "made")
    found = run(Experiment.load(tmp_path / "made"), tmp_path / "out")
    assert found.summary["infeasible_ticks"] == 0
    assert found.summary["tracking"]["max"] < 1e-3


WRONG = {
    "nobody": ({"controller.dependent.nobody": True}, "nobody"),
    "none-independent": (
        {f"controller.dependent.{name}": True for name in ("crank", "coupler", "rocker")},
        "no set of independent coordinates exists",
    ),
    "dart": ({"controller.engine": "dart"}, "closes a loop, which requires engine = 'core'"),
    "law": ({"controller.type": "lyapunov"}, "for a robot with closed loops, not 'lyapunov'"),
    "estimator": (
        {"estimator.length_noise": 1e-4},
        "closes a loop, which the estimator",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_settings_for_loops_are_one_line_errors(case: str, tmp_path: Path) -> None:
    settings, message = WRONG[case]
    text = (
        "[[reference.points]]\ntime = 0.0\nq = { crank = -1.0 }\n"
        "[[reference.points]]\ntime = 1.0\nq = { crank = -1.2 }\n"
        "[controller]\ntype = 'joint_space'\nkp = 100.0\nkd = 20.0\ndependent.crank = false\n"
    )
    folder = write_experiment(four_bar(), tmp_path, text)
    Experiment.load(folder)
    with pytest.raises(InputError, match=message) as raised:
        Experiment.load(folder, settings)
    assert len(str(raised.value).splitlines()) == 1
