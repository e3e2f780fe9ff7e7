"""`cardsflow faults`: the prediction agrees with runs, and inputs are checked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES, PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.motion.look_ahead import LookAhead
from cardsflow_fmu.results.analysis.failures import describe_failures, failures
from cardsflow_fmu.results.analysis.look_ahead import (
    reaction_at,
    with_look_ahead,
    worst_reactions,
)
from cardsflow_fmu.simulation.run import simulate
from cardsflow_fmu.studies.definition.metrics import METRICS

LEFT_ARM = EXAMPLES / "roboy_left_arm"
COARSE = {"controller.period": 0.1}


@pytest.mark.slow
def test_broken_cables_have_the_predicted_effect() -> None:
    """Each cable breaks once at a random time of the flower."""
    settings = {"estimator.encoder_noise": 1e-4, "estimator.feedback": False, "faults.react": True}
    settings |= {"estimator.sensors.length_noise": 1e-4}
    experiment = with_look_ahead(Experiment.load(LEFT_ARM, settings))
    table, random = experiment.look_ahead, np.random.default_rng(2)
    assert table is not None
    limits = [(c.lower, c.upper) for c in experiment.robot.coordinates]
    reactions = set()
    for name, speeds in table.speeds.items():
        time = round(random.uniform(2.2, 4.5), 2)
        expected = reaction_at(speeds[np.searchsorted(table.times, time, "right") - 1])
        changes = {f"plant.break_time.{name}": time, "run.duration": time + 2.0}
        broken = replace(Experiment.load(LEFT_ARM, settings | changes), look_ahead=table)
        result = simulate(broken)
        decided = result.summary["faults"][-1]["decision"]
        error, q, qd = (
            result.columns([n for n in result.names if n.startswith(prefix)])
            for prefix in ("y.", "q.", "qd.")
        )
        error = error - result.columns([n for n in result.names if n.startswith("y_d.")])
        has_fallen = bool(np.linalg.norm(error, axis=1).max() > 5e-3)
        assert has_fallen == (expected == "fall"), name
        wanted = "stop the joints" if has_fallen else expected.partition(" to ")[0]
        assert decided == wanted, name
        assert (result.summary["status"] == "failed") == has_fallen, name
        assert all(
            (low - 1e-9 <= x).all() and (x <= high + 1e-9).all()
            for x, (low, high) in zip(q.T, limits, strict=True)
        )
        if has_fallen or decided == "hold the pose":
            assert np.abs(qd[-1]).max() < 0.02, name
        reactions.add(expected)
    assert reactions == {"continue", "hold the pose", "fall"}


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


def test_worst_reaction_has_its_share_of_the_time() -> None:
    speeds = {"a": (1.0, 0.5, -1.0, -1.0), "b": (1.0, 1.0, 1.0, 1.0), "c": (1.0, 1.0, 1.0, 0.25)}
    table = LookAhead(times=(0.0, 1.0, 2.0, 3.0), speeds=speeds)
    assert worst_reactions(replace(Experiment.load(PLANAR_2R), look_ahead=table)) == {
        "a": "fall (50% of the time)",
        "b": "continue",
        "c": "slow down to 25% (25% of the time)",
    }


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
