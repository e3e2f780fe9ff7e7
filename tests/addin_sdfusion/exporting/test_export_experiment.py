"""Tests of the experiment of an export: it can be read and run, and respects the limits."""

from __future__ import annotations

import contextlib
import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from support.designs.built_stubs import built
from support.robots.random_robots import robots
from support.robots.robots import chain, planar_2r, with_coordinates

from addin_sdfusion.exporting.experiment_text import (
    DURATION,
    can_run,
    experiment_findings,
    experiment_text,
    gentle_motion,
)
from addin_sdfusion.exporting.export import export_built
from addin_sdfusion.robot import RobotError
from addin_sdfusion.settings import ExportSettings
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.cli.main import main

ALL = ExportSettings()


@pytest.mark.slow
@given(robots())
def test_any_motion_is_within_limits_and_read_back_exactly(robot):
    motion = gentle_motion(robot)
    for point in motion.points:
        for c, q in zip(robot.coordinates, point.q, strict=True):
            assert c.lower <= q <= c.upper
    assert motion.points[0].q == motion.points[2].q
    if not can_run(robot):
        assert [f.code for f in experiment_findings(robot)] == ["no-experiment"]
        return
    data = tomllib.loads(experiment_text(robot, motion))
    names = [c.name for c in robot.coordinates]
    for row, point in zip(data["reference"]["points"], motion.points, strict=True):
        assert row == {"time": point.time, "q": dict(zip(names, point.q, strict=True))}


@pytest.mark.parametrize(
    ("lower", "upper", "initial", "there"),
    [
        (-math.inf, math.inf, 0.2, 0.2 + 0.1),
        (-1.0, 1.0, 1.0, 1.0 - 0.1),
        (-1.0, 1.0, -1.0, -1.0 + 0.1),
        (0.0, 0.1, 0.0, 0.05),
        (0.0, 0.1, 0.08, 0.08 - 0.04),
        (0.3, 0.3, 0.3, 0.3),
        (0.0, 1.0, 5.0, 1.0 - 0.1),
    ],
)
def test_motion_uses_the_free_range(lower, upper, initial, there):
    robot = with_coordinates(planar_2r(), lower=lower, upper=upper, initial=initial)
    points = gentle_motion(robot).points
    assert points[0].q[0] == min(max(initial, lower), upper)
    assert points[1].q[0] == pytest.approx(there, abs=1e-15)


def test_names_with_equal_variable_names_are_reported(tmp_path):
    robot = planar_2r()
    joints = tuple(
        replace(j, coordinates=(replace(j.coordinates[0], name=name),))
        for j, name in zip(robot.joints, ("左 1", "左_1"), strict=True)
    )
    exported = export_built(built(replace(robot, joints=joints)), ALL, tmp_path / "arm")
    (finding,) = [f for f in exported.findings if f.code == "experiment-names"]
    assert "'左 1'" in finding.message
    assert main(["run", str(tmp_path / "arm")]) == 2


def test_an_export_without_muscles_reports_that_it_has_no_experiment(tmp_path):
    bare = replace(planar_2r(), cable_sets=(), cable_set="")
    exported = export_built(built(bare), ALL, tmp_path / "arm")
    assert "no-experiment" in [finding.code for finding in exported.findings]
    assert not (tmp_path / "arm/experiment.toml").exists()


@pytest.mark.slow
def test_an_export_runs_and_tracks_its_reference(tmp_path):
    export_built(built(), ALL, tmp_path / "arm")
    assert main(["run", str(tmp_path / "arm"), "--set", "run.duration=0.2"]) == 0
    assert (tmp_path / "arm/results/results.csv").is_file()
    result = run(Experiment.load(tmp_path / "arm"), coupling="direct")
    assert result["time"][-1] == DURATION
    assert not result["infeasible"].any()
    for name in ("joint_1", "joint_2"):
        error = result[f"q.{name}"] - result[f"q_d.{name}"]
        assert np.sqrt(np.mean(error**2)) < 1e-5  # same tolerance as the example, in [rad]
        assert np.ptp(result[f"q.{name}"]) == pytest.approx(0.1, abs=1e-4)


@pytest.mark.parametrize("initial", [-0.3, 0.0, 0.3])
def test_a_run_stays_within_limits(tmp_path, initial):
    """The initial pose may be at a limit."""
    robot = with_coordinates(planar_2r(), lower=-0.3, upper=0.3, initial=initial)
    export_built(built(robot), ALL, tmp_path / "arm")
    changes = {"run.duration": 1.0, "run.step": 0.01, "plant.step": 0.01, "controller.period": 0.01}
    result = run(Experiment.load(tmp_path / "arm", changes), coupling="direct")
    for name in ("joint_1", "joint_2"):
        assert np.abs(result[f"q.{name}"]).max() <= 0.3 + 1e-3


@pytest.mark.slow
def test_a_robot_with_too_weak_muscles_still_runs(tmp_path):
    robot = chain(6, 1, 4)
    export_built(built(robot), ALL, tmp_path / "chain")
    result = run(
        Experiment.load(tmp_path / "chain", {"run.duration": 0.2}),
        tmp_path / "r",
        coupling="direct",
    )
    assert np.isfinite(result["q.joint_5"]).all()


@pytest.mark.slow
@given(robots())
def test_any_robot_that_can_run_loads(tmp_path_factory, robot):
    robot = replace(robot, links=tuple(replace(link, end=None) for link in robot.links))
    if not can_run(robot) or [*experiment_findings(robot)]:
        return
    folder = tmp_path_factory.mktemp("any") / "robot"
    with np.errstate(all="ignore"):
        with contextlib.suppress(RobotError):  # names that SDF reserves
            export_built(built(robot, bodies=0), replace(ALL, caspr=False, osim=False), folder)
        if not folder.exists():
            return
        experiment = Experiment.load(folder)
    assert experiment.robot == robot
    assert experiment.start.q == gentle_motion(robot).points[0].q
