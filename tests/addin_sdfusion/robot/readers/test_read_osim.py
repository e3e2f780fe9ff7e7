"""OpenSim models: M, gravity and lengths agree with OpenSim; omitted parts are reported."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from support.oracles.moving_links import MovingLinks
from support.third_party_models import OSIM

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.finding import Subject
from addin_sdfusion.robot.formats.opensim.reading.functions import read_terms
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.formats.reading.xml import Node, Notes
from addin_sdfusion.robot.model.function import Polynomial, derivatives, value
from addin_sdfusion.robot.model.muscle_laws import law_parameters


def of_text(folder: Path, text: str = OSIM) -> Path:
    file = folder / "leg.osim"
    file.write_text(text)
    return file


def test_all_parts_of_a_small_model_are_read_or_reported(tmp_path: Path) -> None:
    reading = read(of_text(tmp_path))
    robot = reading.require()
    knee, patella = robot.joint("knee"), robot.joint("pat").coordinates[0]
    kinds = [(motion.kind, motion.axis) for motion in knee.motions]
    assert kinds == [("translation", (0, 1, 0)), ("translation", (0, 0, 1)),
                     ("rotation", (0, 0, 1))]  # fmt: skip
    np.testing.assert_allclose(derivatives(knee.motions[0].function, 2.0), (0.17, 0.14, 0.06))
    assert knee.motions[1].displacement(0.7) == 0.05
    assert knee.T_parent_joint.rpy == pytest.approx((0.1, 0.0, 0.0))
    (term,) = patella.coupling
    assert (term.coordinate, term.function) == ("knee_angle", Polynomial((0.5, 1.0)))
    (free,) = robot.coordinates
    assert (free.lower, free.upper, free.initial) == (-2.0, 0.2, 0.3)
    assert (free.actuated, free.tau_min, free.tau_max) == (True, -50.0, 100.0)
    assert free.limit_force is not None
    degree = math.pi / 180.0
    assert free.limit_force.high == pytest.approx(math.pi / 2)
    assert free.limit_force.stiffness_high == pytest.approx(2.0 / degree)
    muscle = robot.muscle("vas")
    values = law_parameters(muscle.model)
    assert (values["max_isometric_force"], values["concentric_shape"]) == (500.0, 0.3)
    assert (values["optimal_fibre_length"], values["elastic_tendon"]) == (0.1, 1.0)
    spring = law_parameters(robot.muscle("band").model)
    assert spring == {"stiffness": 200.0, "rest_length": 0.3, "dissipation": 0.01}
    condition, (wrap,) = muscle.via_points[1].when, muscle.wraps
    assert condition is not None
    assert (condition.coordinate, condition.high) == ("knee_angle", 1e-5)
    assert (wrap.rule, wrap.segment, wrap.last_segment, wrap.quadrant) == ("opensim", 0, 1, "+x")
    reported = {finding.code: str(finding) for finding in reading.findings}
    assert "'rod'" in reported["loop-left-out"]
    assert "HuntCrossleyForce" in reported["force-left-out"]
    line = OSIM[: OSIM.index("<HuntCrossleyForce")].count("\n") + 1
    assert f":{line}: " in reported["force-left-out"]


def test_muscles_of_unknown_classes_become_cables(tmp_path: Path) -> None:
    """They keep their path and maximum force; forces without a maximum are omitted."""
    known = read(of_text(tmp_path)).require().muscle("vas")
    other = OSIM.replace("Thelen2003Muscle", "Delp1990Muscle_Deprecated")
    reading = read(of_text(tmp_path, other))
    muscle = reading.require().muscle("vas")
    assert (muscle.via_points, muscle.wraps) == (known.via_points, known.wraps)
    assert (muscle.model.kind, muscle.f_min, muscle.f_max) == ("ideal", 0.0, 500.0)
    reported = {finding.code: str(finding) for finding in reading.findings}
    assert "<Delp1990Muscle_Deprecated> is not supported" in reported["muscle-as-cable"]
    weak = other.replace("<max_isometric_force>500</max_isometric_force>", "")
    reading = read(of_text(tmp_path, weak))
    assert [muscle.name for muscle in reading.require().muscles] == ["band"]
    assert "muscle-left-out" in {finding.code for finding in reading.findings}


def test_muscle_without_passive_force_has_a_flat_passive_curve(tmp_path: Path) -> None:
    other = OSIM.replace("Thelen2003Muscle", "DeGrooteFregly2016Muscle")
    flag = "<ignore_passive_fiber_force>true</ignore_passive_fiber_force><max_isometric_force>"
    for text, expected in [(other, 0.6), (other.replace("<max_isometric_force>", flag), 1e9)]:
        muscle = read(of_text(tmp_path, text)).require().muscle("vas")
        assert law_parameters(muscle.model)["passive_fibre_strain"] == expected


def test_older_files_are_rejected_with_the_reason(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="which is not supported; open it in OpenSim 4"):
        read(of_text(tmp_path, OSIM.replace('"40000"', '"30000"')))


SHARED = {
    "arm26": 11,
    "gait10dof18musc": 198,
    "gait2392_thelen2003muscle": 1012,
    "leg6dof9musc": 99,
    "subject_walk_scaled": 418,
}
"""Poses for muscles without wraps."""


@pytest.mark.slow
@pytest.mark.parametrize("name", SHARED)
def test_masses_gravity_and_lengths_agree_with_opensim(shared: Path, name: str) -> None:
    file = shared / f"models/opensim/{name}.osim"
    reference = json.loads((shared / f"reference/opensim/{name}.json").read_text())
    reading = read(file)
    robot = reading.require()
    order = [c["name"] for c in reference["coordinates"]]
    compared = 0
    for pose in reference["poses"]:
        at = MovingLinks(robot, dict(zip(order, pose["q"], strict=True)))
        rows = [at.names.index(c) for c in order]
        M, g = at.mass_and_gravity()
        for ours, theirs in ((M[np.ix_(rows, rows)], pose["M"]), (g[rows], pose["gravity_torque"])):
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-14 * np.abs(theirs).max())
        for muscle, length in zip(reference["muscles"], pose["length"], strict=True):
            if not muscle["wraps"]:
                ours = at.straight_length(robot.muscle(muscle["name"]))
                assert ours == pytest.approx(length, rel=1e-14)
                compared += 1
    assert compared == SHARED[name]


def test_empty_elements_have_their_default_with_a_finding(tmp_path: Path) -> None:
    text = OSIM.replace("<dissipation>0.01</dissipation>", "<dissipation></dissipation>")
    assert text != OSIM
    reading = read(of_text(tmp_path, text))
    spring = law_parameters(reading.require().muscle("band").model)
    assert spring["dissipation"] == 0.0
    assert "empty-element" in {finding.code for finding in reading.findings}


def test_repeated_x_of_a_spline_gives_the_slopes_of_opensim(tmp_path: Path) -> None:
    """Values of OpenSim 4.6 at points between; its slopes there are steep, and this on purpose."""
    x, y = "-1 0 0.5 0.5 0.7 1 1 1.5", "0 0 0.3 0.3 0.6 1.0 1.2 1.3"
    node = Node(
        etree.fromstring(f"<SimmSpline name='curve'><x>{x}</x><y>{y}</y></SimmSpline>"),
        tmp_path / "leg.osim",
        Subject("robot", "leg"),
        notes := Notes(),
    )
    ((_, curve),) = read_terms(node, ["q"])
    for at, expected in (
        (0.2, 0.17792001493616422),
        (0.4999, 0.3000066472206686),
        (0.6, 10000.396138912358),
        (0.9, -97776.79113585042),
        (1.2, 400001.2126665897),
    ):
        assert value(curve, at) == pytest.approx(expected, rel=2e-6)
    assert [finding.code for finding in notes.findings] == ["repeated-x", "repeated-x"]
