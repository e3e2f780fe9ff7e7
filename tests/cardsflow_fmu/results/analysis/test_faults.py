"""`cardsflow faults`: the prediction agrees with runs, and inputs are checked."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES, PLANAR_2R

from cardsflow_fmu import Experiment, run
from cardsflow_fmu.results.analysis.failures import describe_failures, failures
from cardsflow_fmu.studies.definition.metrics import METRICS

LEFT_ARM = EXAMPLES / "roboy_left_arm"
COARSE = {"controller.period": 0.1}


@pytest.mark.slow
def test_arm_survives_the_failures_that_its_runs_survive(tmp_path: Path) -> None:
    """Cables that fail from the start of the first two seconds of the flower."""
    duration = {"run.duration": 2.0}
    found = failures(Experiment.load(LEFT_ARM, COARSE | duration))
    predicted = {failure.actuators[0]: failure.is_survived for failure in found[1:]}
    assert sum(predicted.values()) == 10
    for name in ("motor0", "motor6", "motor10"):
        broken = {f"muscles.{name}.f_min": 0.0, f"muscles.{name}.f_max": 1e-6}
        accepted = {"run.accept": "any"}
        result = run(Experiment.load(LEFT_ARM, duration | broken | accepted), tmp_path / name)
        assert (result.summary["tracking"]["max"] < 5e-3) == predicted[name], name


def test_pairs_are_never_easier_than_single_failures() -> None:
    """Without a minimum force, each muscle can only help."""
    settings = {"controller.period": 0.5, "run.duration": 1.0, "muscles.*.f_min": 0.0}
    found = failures(Experiment.load(LEFT_ARM, settings), largest=2)
    single = {f.actuators[0]: f.strength for f in found if len(f.actuators) == 1}
    pairs = [failure for failure in found if len(failure.actuators) == 2]
    assert len(pairs) == 55
    for pair in pairs:
        for name in pair.actuators:
            assert (pair.strength >= single[name] - 1e-6).all()


def test_study_metric_is_the_share_of_feasible_points() -> None:
    settings = {"controller.period": 0.5, "run.duration": 1.0}
    result = SimpleNamespace(experiment=Experiment.load(LEFT_ARM, settings))
    share = METRICS["breaks_survived"].value(result, None, None)
    assert share == pytest.approx(10 / 11)  # only motor10 lifts the forearm


def test_hill_muscles_are_limited_by_their_law() -> None:
    experiment = Experiment.load(EXAMPLES / "hill_arm", COARSE | {"run.duration": 1.0})
    intact = failures(experiment)[0]
    assert (intact.strength > 0.0).all()
    assert (intact.strength < 1.0).all()


def test_command_reports_the_result_first(tmp_path: Path, cardsflow: CommandLine) -> None:
    figure = tmp_path / "faults.svg"
    few = ["--set", "controller.period=0.5"]
    code, out, _ = cardsflow("faults", PLANAR_2R, *few, "-o", figure)
    assert code == 0
    assert out.splitlines()[0] == "the motion survives 0 of 4 single failures"
    assert "cable_1" in figure.read_text()
    data = cardsflow.json("faults", PLANAR_2R, *few)["failures"]
    assert [row["survived"] for row in data] == [True, *[False] * 4]
    weak = ["--set", "muscles.*.f_max=12"]
    code, out, _ = cardsflow("faults", PLANAR_2R, *few, *weak)
    assert code == 1
    assert out.startswith("infeasible: the intact robot is too weak for the motion")


def test_survived_failures_are_counted_and_others_are_named() -> None:
    found = failures(Experiment.load(LEFT_ARM, COARSE | {"run.duration": 1.0}))
    first = describe_failures(found).splitlines()[0]
    assert first == (
        "the motion survives 10 of 11 single failures; it is infeasible without motor10"
    )
    assert np.isfinite(found[0].strength).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-o", "faults.txt"], "no kind of figure 'txt'"),
        (["--set", "run.duration=-1"], "run.duration"),
        (["nowhere"], "cannot be read"),
    ],
)
def test_invalid_input_is_rejected_in_one_line(
    arguments: list[str], message: str, cardsflow: CommandLine
) -> None:
    experiment = [] if arguments == ["nowhere"] else [PLANAR_2R]
    assert message in cardsflow.error_line("faults", *experiment, *arguments)
