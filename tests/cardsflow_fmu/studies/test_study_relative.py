"""Relative variations: factors of nominal values and offsets from them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from support.small_studies import ROOT, small_study

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.nominal_values import nominal_value
from cardsflow_fmu.studies import Study
from cardsflow_fmu.studies.definition.sampling import Run, expand

LEFT_ARM = ROOT / "examples" / "roboy_left_arm"
POINT = "robot.muscles.cable_1.points[1].position"


def vary(path: str, values: str) -> str:
    return f"[[vary]]\npath = '{path}'\n{values}\n"


def runs(study: Study) -> list[Run]:
    return list(expand(study, "x"))


def test_a_factor_scales_the_nominal_value(tmp_path: Path) -> None:
    path = "robot.links.link_1.inertia.mass"
    study = small_study(tmp_path, vary(path, "values = [0.8, 1.0, 1.2]\nrelative = 'factor'"))
    mass = Experiment.load(study.experiment).robot.links[0].inertia.mass
    low, same, high = runs(study)
    assert same.settings == {path: mass}
    assert (low.settings[path], high.settings[path]) == (0.8 * mass, 1.2 * mass)
    assert [run.values[path] for run in (low, same, high)] == [0.8, 1.0, 1.2]


def test_every_name_that_a_star_matches_has_a_separate_nominal_value(tmp_path: Path) -> None:
    text = vary("robot.links.*.inertia.ixx", "values = [2.0]\nrelative = 'factor'")
    experiment = small_study(tmp_path, text).experiment
    for robot_link in Experiment.load(experiment).robot.links:
        (run,) = runs(small_study(tmp_path, text))
        path = f"robot.links.{robot_link.name}.inertia.ixx"
        assert run.settings[path] == 2.0 * robot_link.inertia.ixx


def test_together_applies_one_factor_to_all_names(tmp_path: Path) -> None:
    values = "values = [0.5]\nrelative = 'factor'\ntogether = true"
    study = small_study(tmp_path, vary("muscles.*.f_max", values))
    (variation,) = study.variations
    (run,) = runs(study)
    muscles = Experiment.load(study.experiment).robot.muscles
    assert run.settings == {f"muscles.{m.name}.f_max": 0.5 * m.f_max for m in muscles}
    assert run.values == {variation.name: 0.5}


def test_an_offset_moves_a_point_in_a_box_about_its_position(tmp_path: Path) -> None:
    box = "box = { from = [-0.01, 0.0, -0.02], to = [0.01, 0.0, 0.02] }\nrelative = 'offset'"
    study = small_study(tmp_path, vary(POINT, box), "count = 64\nsampler = 'sobol'")
    muscle = Experiment.load(study.experiment).robot.muscles[0]
    x, y, z = muscle.via_points[1].position
    for run in runs(study):
        assert abs(run.settings[f"{POINT}[0]"] - x) <= 0.01
        assert run.settings[f"{POINT}[1]"] == y
        assert abs(run.settings[f"{POINT}[2]"] - z) <= 0.02
    moved = Experiment.load(study.experiment, runs(study)[3].settings)
    assert moved.robot.muscles[0].via_points[1].position == tuple(
        runs(study)[3].settings[f"{POINT}[{axis}]"] for axis in range(3)
    )


def test_a_factor_scales_a_vector(tmp_path: Path) -> None:
    study = small_study(tmp_path, vary("controller.kp", "values = [2.0]\nrelative = 'factor'"))
    (run,) = runs(study)
    known = Experiment.load(study.experiment).controller.kp
    assert run.settings["controller.kp"] == [2.0 * kp for kp in known]
    changed = Experiment.load(study.experiment, run.settings)
    assert changed.controller.kp == tuple(2.0 * kp for kp in known)


@pytest.mark.parametrize(
    ("path", "number"),
    [
        ("controller.period", 0.005),
        ("controller.kp", (400.0, 400.0, 400.0)),
        ('controller.kp."hand.y"', 400.0),
        ("controller.posture.q0", (1.45, 0.0, 0.0, -1.3)),
        ("plant.step", 0.001),
        ("reference.flower.radius", 0.15),
        ("reference.flower.centre[1]", -0.45),
        ("reference.approach.duration", 2.0),
        ("run.duration", 32.0),
        ("hardware.watchdog", 0.02),
    ],
)
def test_nominal_values_equal_the_values_in_the_file(path: str, number: Any) -> None:
    assert nominal_value(Experiment.load(LEFT_ARM), path) == number


@pytest.mark.parametrize(
    ("path", "values", "message"),
    [
        ("controller.delay", "values = [1.0]\nrelative = 'factor'", "not a real number"),
        ("controller.solver", "values = [1.0]\nrelative = 'factor'", "'.*', not a real number"),
        ("controller.kp", "values = [1.0]\nrelative = 'offset'", "is a vector"),
        ("controller.ki.joint_1", "values = [1.0]\nrelative = 'factor'", "is 0"),
        ("controller.kp", "values = ['a']\nrelative = 'factor'", "relative values must be numbers"),
        (
            "controller.kp",
            "values = [true]\nrelative = 'factor'",
            "relative values must be numbers",
        ),
        ("controller.kp", "values = [1.0]\nrelative = true", "must be 'factor' or 'offset'"),
        ("controller.kp", "values = [1.0]\nrelative = ['factor']", "must be 'factor' or 'offset'"),
        ("controller.delay", "seed = true\nrelative = 'offset'", "a seed cannot be relative"),
        ("controller.kpp", "values = [1.0]\nrelative = 'factor'", "kp"),
    ],
)
def test_invalid_relative_values_are_rejected(
    tmp_path: Path, path: str, values: str, message: str
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        small_study(tmp_path, vary(path, values))
    assert caught.value.file == tmp_path / "study.toml"


@pytest.mark.parametrize(
    ("first", "second"),
    [("controller.kp.joint_1", "controller.kp"), (f"{POINT}[0]", POINT)],
)
def test_a_path_that_overwrites_another_is_rejected(
    tmp_path: Path, first: str, second: str
) -> None:
    given = {"controller.kp": "values = [900.0]", POINT: "values = [[0.1, 0.0, 0.8]]"}
    texts = vary(first, "values = [1.0]"), vary(second, given[second])
    with pytest.raises(InputError, match="overwrites an earlier variation"):
        small_study(tmp_path, "".join(texts))


def test_a_part_can_be_varied_after_the_whole(tmp_path: Path) -> None:
    text = vary("controller.kp", "values = [900.0]")
    study = small_study(tmp_path, text + vary("controller.kp.joint_1", "values = [500.0]"))
    (run,) = runs(study)
    assert Experiment.load(study.experiment, run.settings).controller.kp == (500.0, 900.0)
