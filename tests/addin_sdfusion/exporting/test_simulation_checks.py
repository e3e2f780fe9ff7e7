"""Tests of the gentle motion of an export, and of the warnings on simulations."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from support.designs.built_stubs import built
from support.robots.random_robots import robots
from support.robots.robots import planar_2r, with_coordinates

from addin_sdfusion.exporting.export import export_built
from addin_sdfusion.exporting.gentle_motion import gentle_motion
from addin_sdfusion.exporting.simulation_checks import can_simulate, simulation_findings
from addin_sdfusion.settings import ExportSettings
from cardsflow_fmu.cli.main import main

ALL = ExportSettings()


@pytest.mark.slow
@given(robots())
def test_any_motion_is_within_limits(robot):
    motion = gentle_motion(robot)
    for point in motion.points:
        for c, q in zip(robot.coordinates, point.q, strict=True):
            assert c.lower <= q <= c.upper
    assert motion.points[0].q == motion.points[2].q
    if not can_simulate(robot):
        assert [f.code for f in simulation_findings(robot)] == ["no-experiment"]


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
    assert main(["init", str(tmp_path / "arm"), "-o", str(tmp_path / "new")]) == 2


def test_an_export_without_muscles_reports_that_it_has_no_experiment(tmp_path):
    bare = replace(planar_2r(), cable_sets=(), cable_set="")

    def experiment(folder):
        raise AssertionError(folder)

    exported = export_built(built(bare), ALL, tmp_path / "arm", experiment=experiment)
    assert "no-experiment" in [finding.code for finding in exported.findings]
    assert not (tmp_path / "arm/experiment.toml").exists()


def test_losses_contain_only_the_findings_of_one_format(tmp_path):
    exported = export_built(built(bodies=2), replace(ALL, mjcf=True), tmp_path / "arm")
    assert set(exported.losses) <= {"caspr", "osim", "mjcf"}
    assert {f.code for f in exported.losses["caspr"]} >= {"caspr-meshes", "caspr-link-ends"}
    assert "limits-are-ranges" in {f.code for f in exported.losses["osim"]}
    for losses in exported.losses.values():
        assert set(losses) <= set(exported.findings)
