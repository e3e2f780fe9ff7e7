"""Optimisation: searches, constraints and the best robot."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.designs.small_designs import arm, via
from support.small_studies import PLANAR, run_here, small_study, write_study

from addin_sdfusion.building.build_robot import build_robot
from addin_sdfusion.muscles.csv_reader import read_csv
from addin_sdfusion.muscles.csv_writer import csv_text
from addin_sdfusion.muscles.merge import merge
from addin_sdfusion.muscles.table import MuscleTable
from addin_sdfusion.robot import read_robot
from addin_sdfusion.robot.formats.read import read_trajectories
from addin_sdfusion.snapshot import MuscleSnapshot
from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.run import simulate
from cardsflow_fmu.studies.analysis.best_robot import muscle_table, write_best
from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.sampling import Run
from cardsflow_fmu.studies.definition.tables import Constraint, Optimise
from cardsflow_fmu.studies.execution.optimisation import cost, optimise

BOX = """
[[vary]]
name = "end_1"
path = "robot.muscles.cable_1.points[1].position"
box = { from = [0.02, 0.0, 0.5], to = [0.25, 0.0, 0.95] }
"""
SEARCH = """
[optimise]
method = "%s"
objective = "force.peak"
population = 8
generations = %d
seeds = %s
constraints = [{ metric = "infeasible_ticks", at_most = 0 }]
"""
BEST = (0.1, 0.8)


def bowl(runs: Iterable[Run]) -> list[Outcome]:
    """Return the squared distance to BEST instead of simulating; infeasible for x > 0.2."""
    outcomes = []
    for run in runs:
        x, y, z = run.values.values()
        assert y == 0.0
        square = (x - BEST[0]) ** 2 + (z - BEST[1]) ** 2
        outcomes.append(Outcome({"force.peak": square, "infeasible_ticks": float(x > 0.2)}))
    return outcomes


METHODS = ["differential_evolution", pytest.param("cma_es", marks=pytest.mark.extra("optimise"))]


@pytest.mark.parametrize("method", METHODS)
def test_searches_find_the_minimum_of_a_quadratic_function(tmp_path: Path, method: str) -> None:
    study = small_study(tmp_path, BOX + SEARCH % (method, 40, "[1, 2]"))
    found = optimise(study, "x", bowl)
    again = optimise(study, "x", bowl)
    assert [run.hash for run, _ in found.runs] == [run.hash for run, _ in again.runs]
    assert found.best is not None
    run, _ = found.runs[found.best]
    assert (run.values["end_1[0]"], run.values["end_1[2]"]) == pytest.approx(BEST, abs=1e-3)
    assert set(found.history) == {"seed 1", "seed 2"}
    for history in found.history.values():
        falling = [value for value in history if not math.isnan(value)]
        assert falling == sorted(falling, reverse=True)
    assert all(0.02 <= run.values["end_1[0]"] <= 0.25 for run, _ in found.runs)


def test_costs_of_violated_constraints_exceed_all_objectives() -> None:
    limits = (Constraint(metric="a", at_least=1.0), Constraint(metric="b", at_most=0.0))
    settings = Optimise(
        method="cma_es", objective="f", population=8, generations=1, constraints=limits
    )
    good = cost(settings, Outcome({"f": 1e6, "a": 1.0, "b": 0.0}))
    near = cost(settings, Outcome({"f": 0.0, "a": 0.9, "b": 0.0}))
    far = cost(settings, Outcome({"f": 0.0, "a": 0.9, "b": 5.0}))
    assert good == 1e6
    assert good < near < far < cost(settings, Outcome({}, "broken"))
    assert cost(settings, Outcome({"f": None, "a": 1.0, "b": 0.0})) == cost(
        settings, Outcome({}, "broken")
    )


def test_maximising_negates_the_objective() -> None:
    settings = Optimise(method="cma_es", objective="f", maximise=True, population=8, generations=1)
    assert cost(settings, Outcome({"f": 3.0})) == -3.0


@pytest.mark.slow
def test_a_search_is_resumed_and_its_best_robot_runs(tmp_path: Path) -> None:
    search = SEARCH % ("differential_evolution", 3, "[4]")
    study = small_study(tmp_path, BOX + search, "metrics = ['tracking.rms']")
    result = run_here(study, tmp_path / "out")
    table = (tmp_path / "out" / "table.csv").read_bytes()
    removed = sorted((tmp_path / "out" / "runs").iterdir())[::2]
    for file in removed:
        file.unlink()
    run_here(study, tmp_path / "out", resume=True)
    assert removed
    assert (tmp_path / "out" / "table.csv").read_bytes() == table
    best = result.summary["best"]
    rows = [outcome.metrics["force.peak"] for _, outcome in result.rows()]
    assert best["objective"] == min(rows)
    alone = simulate(Experiment.load(tmp_path / "out" / "best" / "experiment.json"))
    assert alone.summary["forces"]["max"] == pytest.approx(best["objective"], rel=1e-9)
    assert "force.peak" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.slow
def test_a_search_without_feasible_robots_reports_it(tmp_path: Path) -> None:
    search = (SEARCH % ("differential_evolution", 1, "[4]")).replace("at_most = 0", "at_most = -1")
    result = run_here(small_study(tmp_path, BOX + search), tmp_path / "out")
    assert result.summary["best"] is None
    assert "No run satisfies" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.slow
def test_a_search_with_only_failed_runs_ends_and_reports_it(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    negative = "[[vary]]\npath = 'controller.kp'\nuniform = [-2.0, -1.0]\n"
    file = write_study(tmp_path, negative + SEARCH % ("differential_evolution", 2, "[0]"))
    code, text, _ = cardsflow("study", file, "-j", 1)
    assert code == 1
    assert "no run meets the constraints" in text
    assert "kp: must be above 0" in text
    assert json.loads((tmp_path / "results/summary.json").read_text())["best"] is None


def test_the_best_robot_is_the_same_in_every_format(tmp_path: Path) -> None:
    path = "robot.muscles.cable_1.points[1].position"
    experiment = Experiment.load(PLANAR, {path: [0.123456789012345, 0.0, 0.7]})
    write_best(experiment, tmp_path)
    for format_ in ("sdf", "caspr"):
        muscles = read_robot(tmp_path / format_, experiment.robot.cable_set).muscles
        for written, original in zip(muscles, experiment.robot.muscles, strict=True):
            assert written.name == original.name
            for one, other in zip(written.via_points, original.via_points, strict=True):
                assert one.position == pytest.approx(other.position, abs=1e-12)
    trajectories, unread = read_trajectories(experiment.robot_path)
    assert (len(trajectories), unread) == (3, [])
    (bodies,) = (tmp_path / "caspr").glob("*_bodies.xml")
    assert read_trajectories(bodies) == (trajectories, [])
    table, findings = read_csv((tmp_path / "muscles.csv").read_bytes())
    assert not findings
    assert table == muscle_table(experiment.robot)
    saved = json.loads((tmp_path / "experiment.json").read_text())
    assert "muscles" not in saved["robot"]


def test_via_points_are_in_the_root_frame() -> None:
    """With both joints at zero, link 2 begins 1 m above the origin."""
    robot = Experiment.load(PLANAR).robot
    points = {(p.muscle, p.number): p for p in muscle_table(robot).points}
    assert points["cable_2", 2].position == pytest.approx((0.1, 0.0, 1.8))
    assert points["cable_1", 2].position == pytest.approx((0.1, 0.0, 0.8))
    assert np.isfinite([p.position for p in points.values()]).all()


def test_the_add_in_imports_the_best_robot() -> None:
    """Points of a robot from a design are moved, written as CSV and read into the design."""
    design = arm()
    robot = build_robot(design).robot
    (muscle,) = robot.muscles
    moved = [
        replace(p, position=(x + 0.0123, y - 1.0 / 3.0, z + 0.007))
        for p, (x, y, z) in ((p, p.position) for p in muscle.via_points)
    ]
    best = robot.with_muscles([replace(muscle, via_points=tuple(moved), f_max=77.0)])
    links = {link.name for link in robot.links}
    table, findings = read_csv(csv_text(muscle_table(best)).encode(), links)
    assert not findings
    drawn = merge(MuscleTable(), table)
    points = [via(p.muscle, p.number, p.link, p.position) for p in drawn.points]
    rows = tuple(MuscleSnapshot(row.name, f_min=row.f_min, f_max=row.f_max) for row in drawn.rows)
    again = build_robot(arm(points=tuple(points), muscles=rows)).robot
    (found,) = again.muscles
    assert (found.f_min, found.f_max) == (muscle.f_min, 77.0)
    for one, other in zip(found.via_points, moved, strict=True):
        assert one.link == other.link
        assert one.position == pytest.approx(other.position, abs=1e-12)
