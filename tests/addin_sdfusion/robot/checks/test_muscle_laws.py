"""Checks of muscle laws, and muscle laws in files."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from support.robots.muscle_bench import BROKEN_RULES, HILL, SOUND, slider, values_outside_bounds
from support.robots.one_link import cable, one_link

from addin_sdfusion.muscles.attributes import muscles_text
from addin_sdfusion.muscles.csv_reader import read_csv
from addin_sdfusion.muscles.csv_writer import csv_text
from addin_sdfusion.muscles.stored import stored_muscles
from addin_sdfusion.muscles.table import MuscleTable
from addin_sdfusion.robot import (
    CableModel,
    CableSet,
    CardsflowError,
    RobotError,
    caspr_losses,
    check,
    read_robot,
    write_caspr,
    write_sdf,
)
from addin_sdfusion.robot.checks.check import require_valid
from addin_sdfusion.robot.model.laws import MUSCLE_LAWS
from addin_sdfusion.snapshot import MuscleSnapshot
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core

KINDS = [kind for kind in SOUND if MUSCLE_LAWS[kind].parameters]
NAMED = [(kind, p) for kind in KINDS for p in MUSCLE_LAWS[kind].parameters]


def _passive(robot):
    """Return whether a muscle is a passive spring of CASPR, which has no force limits."""
    muscles = [
        replace(m, f_max=0.0) if m.model.kind == "passive_spring" else m for m in robot.muscles
    ]
    return robot.with_muscles(muscles)


def _errors(kind, parameters):
    robot = _passive(slider((kind, parameters)))
    return [finding for finding in check(robot) if finding.is_error]


@pytest.mark.parametrize("kind", SOUND)
def test_valid_laws_have_no_findings(kind):
    robot = _passive(slider((kind, SOUND[kind])))
    (joint,) = robot.joints
    coordinate = replace(joint.coordinates[0], initial=0.3)  # muscles have a length
    robot = replace(robot, joints=(replace(joint, coordinates=(coordinate,)),))
    assert not [f for f in check(robot) if f.subject[1] == "m0"]


@pytest.mark.parametrize(("kind", "parameter"), NAMED)
def test_number_outside_its_limits_is_reported_with_muscle_name(kind, parameter):
    for value in values_outside_bounds(parameter):
        (found,) = _errors(kind, SOUND[kind] | {parameter.name: value})
        assert found.code == "bad-law-parameter"
        assert found.subject == ("muscle", "m0")
        assert (
            found.message
            == f"muscle 'm0': {kind}: {parameter.name} {value!r} must be {parameter.bounds}"
        )


@pytest.mark.parametrize("kind", ["series_elastic_motor", "hill_millard2012"])
def test_denormal_numbers_are_rejected_or_valid(kind):
    """Quotients of such numbers are not finite."""
    for parameter in MUSCLE_LAWS[kind].parameters:
        for found in _errors(kind, SOUND[kind] | {parameter.name: 5e-324}):
            assert found.code == "bad-law-parameter"


@pytest.mark.parametrize(("kind", "parameter"), NAMED)
def test_parameter_without_default_is_required(kind, parameter):
    left = {name: value for name, value in SOUND[kind].items() if name != parameter.name}
    codes = [(f.code, parameter.name in f.message) for f in _errors(kind, left)]
    assert codes == ([("missing-law-parameter", True)] if parameter.default is None else [])


def test_unknown_parameter_suggests_nearest_name():
    (found,) = _errors("elastic_cable", SOUND["elastic_cable"] | {"dampnig": 3.0})
    assert found.code == "unknown-law-parameter"
    assert "no parameter 'dampnig'" in found.message
    assert "damping" in found.message


def test_repeated_parameter_is_reported():
    robot = slider(("elastic_cable", {}))
    model = CableModel("elastic_cable", (("stiffness", 1.0), ("stiffness", 2.0)))
    robot = robot.with_muscles([replace(robot.muscles[0], model=model)])
    assert [f.code for f in check(robot) if f.is_error] == ["repeated-law-parameter"]


@pytest.mark.parametrize(("kind", "parameters", "what"), BROKEN_RULES)
def test_inconsistent_parameters_are_reported(kind, parameters, what):
    (found,) = _errors(kind, SOUND[kind] | parameters)
    assert (found.code, found.subject.name) == ("bad-law-parameter", "m0")
    assert found.message.startswith(f"muscle 'm0': {kind}: {what} must hold")


@pytest.mark.cases(4)
@pytest.mark.slow
@pytest.mark.native
@pytest.mark.parametrize("kind", KINDS)
def test_core_accepts_laws_that_pass_the_check(kind):
    """Random numbers near the defaults and at the limits; check and core reject some of them."""
    rng = np.random.default_rng(len(kind))
    passed = 0
    parameters = MUSCLE_LAWS[kind].parameters
    for _ in range(200):
        values = dict(SOUND[kind])
        for k in rng.choice(len(parameters), 2):
            p = parameters[k]
            usual = values.get(p.name, p.default) or 1.0
            ends = [end for end in (p.low, p.high) if math.isfinite(end)]
            values[p.name] = float(rng.choice([usual * 10.0 ** rng.normal(0.0, 0.4), *ends]))
        if _errors(kind, values):
            continue
        passed += 1
        try:
            Core(compile_blob(slider((kind, values))))
        except CardsflowError as error:
            raise AssertionError(values) from error
    assert passed > 25


def test_invalid_laws_of_any_cable_set_are_reported_and_not_simulated():
    robot = slider(("elastic_cable", {"stiffness": -5.0}))
    other = CableSet("other", robot.muscles)
    sound = slider(("ideal", {}))
    both = replace(sound, cable_sets=(*sound.cable_sets, other))
    assert [f.subject.name for f in check(both) if f.is_error] == ["other/m0"]
    with pytest.raises(RobotError, match=r"stiffness -5\.0 must be above 0"):
        require_valid(robot)


@pytest.mark.parametrize("kind", SOUND)
def test_files_restore_all_laws_exactly(kind, tmp_path):
    odd = {name: value * (1.0 + 1e-15) for name, value in SOUND[kind].items()}
    robot = _passive(slider((kind, odd)))
    write_sdf(robot, tmp_path)
    assert read_robot(tmp_path).muscles == robot.muscles


@pytest.mark.parametrize("kind", SOUND)
def test_design_table_restores_all_laws(kind):
    rows = (MuscleSnapshot("m", "#112233", 1.0, 20.0, kind, SOUND[kind]),)
    findings: list = []
    assert stored_muscles({"muscles": muscles_text(rows)}, "robot", findings) == rows
    table, findings = read_csv(csv_text(MuscleTable(rows)).encode())
    assert not findings
    assert table.rows == rows


def test_caspr_writes_ideal_cables_with_a_finding(tmp_path):
    robot = slider(("hill_thelen2003", HILL), ("ideal", {}))
    reported = {f.subject.name: f.code for f in caspr_losses(robot) if f.subject.kind == "muscle"}
    assert reported == {"m0": "caspr-tension-law"}
    write_caspr(robot, tmp_path)
    back = read_robot(tmp_path / "slider_bodies.xml")
    assert [muscle.model.kind for muscle in back.muscles] == ["ideal", "ideal"]


@pytest.mark.parametrize(
    ("cord", "thread", "is_reported"),
    [(0.3, 0.8, False), (1.1, 0.8, True), (0.3, 0.6, True), (0.0, 1.01, False)],
)
def test_impossible_bladder_lengths_are_reported(
    cord: float, thread: float, is_reported: bool
) -> None:
    values = (("thread_length", thread), ("turns", 2.0), ("cord_length", cord))
    model = CableModel("mckibben", values)
    muscle = cable((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), model=model)  # 1 m
    codes = {finding.code for finding in check(one_link(muscles=[muscle]))}
    assert ("bladder-length" in codes) == is_reported
