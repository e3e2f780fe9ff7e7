"""Settings of several muscles by patterns of their names."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot.model.muscle_laws import law_parameters
from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.writer import experiment_data
from sim_dart import MusclePaths, Plant

ARM = EXAMPLES / "hill_arm"


def f_max(experiment: Experiment) -> dict[str, float]:
    return {muscle.name: muscle.f_max for muscle in experiment.robot.muscles}


def test_pattern_applies_to_all_matching_muscles() -> None:
    bounds = f_max(Experiment.load(ARM, {"muscles.triceps_*.f_max": 321.0}))
    assert {name for name, bound in bounds.items() if bound == 321.0} == {
        "triceps_lateral",
        "triceps_long",
    }
    assert set(f_max(Experiment.load(PLANAR_2R, {"muscles.*.f_max": 50.0})).values()) == {50.0}
    bounds = f_max(Experiment.load(PLANAR_2R, {"robot.muscles.cable_?.f_max": 60.0}))
    assert set(bounds.values()) == {60.0}


def test_name_has_precedence_over_a_pattern() -> None:
    tables = {"cable_2": {"f_max": 70.0}, "*": {"f_max": 50.0, "f_min": 5.0}}
    experiment = Experiment.load(PLANAR_2R, {"muscles": tables})
    assert f_max(experiment) == {"cable_1": 50.0, "cable_2": 70.0, "cable_3": 50.0, "cable_4": 50.0}
    assert {muscle.f_min for muscle in experiment.robot.muscles} == {5.0}


def test_pattern_of_a_setting_has_precedence_over_a_name_in_the_file() -> None:
    """As any setting with `--set`."""
    settings = {"muscles": {"cable_2": {"f_max": 70.0}}, "muscles.cable_*.f_max": 50.0}
    assert set(f_max(Experiment.load(PLANAR_2R, settings)).values()) == {50.0}


def test_relative_lengths_use_the_path_length_at_a_pose() -> None:
    experiment = Experiment.load(ARM)
    pose = {c.name: 0.3 for c in experiment.robot.coordinates}
    model = {
        "kind": "hill_millard2012",
        "max_isometric_force": "f_max",
        "optimal_fibre_length": "0.7 path",
        "tendon_slack_length": 0.02,
    }
    table = {"*": {"f_max": 800.0, "model": model, "pose": pose}}
    changed = Experiment.load(ARM, {"muscles": table}).robot
    lengths = MusclePaths(experiment.robot).evaluate(list(pose.values())).lengths
    for muscle, length in zip(changed.muscles, lengths, strict=True):
        values = law_parameters(muscle.model)
        assert values["max_isometric_force"] == 800.0
        assert values["optimal_fibre_length"] == pytest.approx(0.7 * length, rel=1e-12)
        assert values["tendon_slack_length"] == 0.02


def test_hill_from_path_has_optimal_fibre_length_for_all_muscles() -> None:
    """At the initial pose, the active force is at its maximum: F0 at full activation."""
    settings = {"muscles": {"*": {"f_max": 400.0, "model": "hill_from_path"}}}
    experiment = Experiment.load(ARM, settings)
    laws = [law_parameters(muscle.model) for muscle in experiment.robot.muscles]
    found = [law["optimal_fibre_length"] + law["tendon_slack_length"] for law in laws]
    plant = Plant(experiment.robot, step=1e-4)
    np.testing.assert_allclose(plant.lengths_view, found, rtol=1e-12)
    plant.step(np.zeros(len(laws)))
    assert np.all(plant.tensions < 0.05 * 400.0)  # neither active nor stretched


def test_packed_parameters_are_numbers_instead_of_expressions() -> None:
    settings = {"muscles": {"*": {"f_max": 400.0, "model": "hill_from_path"}}}
    data = experiment_data(Experiment.load(ARM, settings))
    assert set(data["muscles"]) == {m.name for m in Experiment.load(ARM).robot.muscles}
    assert all(
        isinstance(value, float)
        for table in data["muscles"].values()
        for key, value in table["model"].items()
        if key != "kind"
    )
