"""Published CASPR models: their findings, and writing and reading them."""

from __future__ import annotations

from collections import Counter

import pytest

from addin_sdfusion.robot import caspr_losses, read_robot
from addin_sdfusion.robot.formats.convert import convert
from addin_sdfusion.robot.formats.read import read, read_trajectories, trajectory_names

VSD = {"cable-model-not-simulated": 6}

FINDINGS = {
    ("BMArm", "WORKING"): {},
    ("BMArm", "vsd_test"): VSD,
    ("BMArm", "multi_link"): VSD,
    ("Example_2R_planar_XZ", "basic"): {"zero-inertia-about-axis": 2},
    ("Example_2R_planar_XZ", "basic_multi_segment"): {"zero-inertia-about-axis": 2},
    ("Example_planar_XY", "basic"): {},
    ("Example_planar_XY", "basic_notouch"): {},
    ("Example_planar_XY", "basic_cross"): {},
    ("Example_spatial", "basic_7_cables"): {},
    ("Example_spatial", "alternative_7_cables"): {},
    ("Example_spatial", "basic_8_cables"): {},
    ("Example_spatial", "cross_8_cables"): {},
    ("Example_spherical", "basic_4_cables"): {},
    ("Example_spherical", "VSD_6_cables"): VSD,
    ("Example_spherical", "VSD_6_cables_2"): VSD,
    ("RoboyLeftArm", "DEFAULT"): {},
    ("RoboyUpperBody", "DEFAULT"): {"inertia-triangle": 19},
}
"""Findings on each model with each of its cable sets; all are warnings."""

TRAJECTORIES = {
    "BMArm": ({"quintic": 13, "linear": 1}, {"quintic": 5}),
    "Example_2R_planar_XZ": ({"quintic": 14, "linear": 2, "cubic": 2}, {"quintic": 1}),
    "Example_planar_XY": (
        {"linear": 1, "cubic": 2, "quintic": 8, "parabolic_blend": 1, "samples": 1},
        {},
    ),
    "Example_spatial": ({"quintic": 3}, {}),
    "Example_spherical": ({}, {}),
    "RoboyLeftArm": ({}, {"quintic": 1}),
    "RoboyUpperBody": ({"quintic": 1}, {}),
}
"""Number of joint-space and operational-space trajectories of each type, by model."""


def folder(shared, model):
    return shared / "robots/caspr" / model


def stored(file):
    bodies = file.with_name(file.name.replace("_trajectories", "_bodies"))
    trajectories, unread = read_trajectories(bodies)
    assert unread == []
    assert [t.name for t in trajectories] == [
        name for space in ("joint", "operational") for name in trajectory_names(file, space)
    ]
    return trajectories


@pytest.mark.parametrize(("model", "cable_set"), FINDINGS)
def test_model_has_its_known_findings(shared, model, cable_set):
    reading = read(folder(shared, model), cable_set)
    assert reading.robot.cable_set == cable_set
    assert Counter(f.code for f in reading.findings) == FINDINGS[model, cable_set]
    assert {f.severity for f in reading.findings} <= {"warning"}


@pytest.mark.parametrize("model", TRAJECTORIES)
def test_all_cable_sets_of_a_model_are_in_the_table(shared, model):
    sets = [group.name for group in read_robot(folder(shared, model)).cable_sets]
    assert sets == [cable_set for name, cable_set in FINDINGS if name == model]


@pytest.mark.parametrize("model", TRAJECTORIES)
def test_all_trajectories_of_a_model_are_read(shared, model):
    trajectories = stored(folder(shared, model) / f"{model}_trajectories.xml")
    for space, kinds in zip(("joint", "operational"), TRAJECTORIES[model], strict=True):
        assert Counter(t.spline for t in trajectories if t.space == space) == kinds


@pytest.mark.slow
@pytest.mark.parametrize(("model", "cable_set"), FINDINGS)
def test_model_is_unchanged_after_writing_and_reading(shared, model, cable_set, tmp_path):
    robot = read_robot(folder(shared, model), cable_set)
    trajectories = stored(folder(shared, model) / f"{model}_trajectories.xml")
    lost = convert(robot, "caspr", tmp_path, trajectories).findings
    assert {finding.code for finding in lost} <= {"caspr-trajectory-size"}
    assert read_robot(tmp_path) == robot
    assert stored(tmp_path / f"{model}_trajectories.xml") == trajectories


@pytest.mark.parametrize("model", TRAJECTORIES)
def test_only_one_trajectory_matches_no_operational_space(shared, model):
    robot = read_robot(folder(shared, model))
    trajectories = stored(folder(shared, model) / f"{model}_trajectories.xml")
    reported = [(f.code, f.subject.name) for f in caspr_losses(robot, trajectories)]
    odd = [("caspr-trajectory-size", "simple_motion")]
    assert reported == (odd if model == "Example_2R_planar_XZ" else [])
