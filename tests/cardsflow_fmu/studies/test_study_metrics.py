"""Metrics of a run, compared with closed forms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.small_studies import PLANAR

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.simulation.run import simulate
from cardsflow_fmu.studies.definition.metrics import (
    METRICS,
    expand_wildcards,
    metric_units,
    metric_values,
)
from cardsflow_fmu.studies.definition.tables import Box
from controllers.analysis.gains import margins
from sim_dart import DartDynamics

SETTINGS = {"controller.period": 0.01, "run.step": 0.01, "run.duration": 0.3}


@pytest.fixture(scope="module")
def result() -> Result:
    return simulate(Experiment.load(PLANAR, SETTINGS), coupling="direct")


def with_columns(result: Result, **columns: np.ndarray) -> Result:
    """Return the result with changed columns; `f_cable_1` is the column `f.cable_1`."""
    rows = result.rows.copy()
    for name, values in columns.items():
        rows[:, result.names.index(f"{name[0]}.{name[2:]}")] = values
    return replace(result, rows=rows)


def test_force_metrics_match_closed_forms(result: Result) -> None:
    t = np.linspace(0.0, 2.0 * np.pi, len(result.rows), endpoint=False)
    one = with_columns(result, f_cable_2=200.0 + 30.0 * np.sin(t))
    names = ["force.peak", "force.peak.cable_2", "force.rms.cable_2", "force.low.cable_2"]
    peak, single, rms, low = metric_values(names, one, None).values()
    assert peak == single == pytest.approx(230.0, abs=0.2)
    assert low == pytest.approx(170.0, abs=0.2)
    assert rms == pytest.approx(np.sqrt(200.0**2 + 30.0**2 / 2.0), rel=1e-12)


def test_energy_is_force_times_distance(result: Result) -> None:
    """A constant force of 50 N over 0.2 m in both directions is 20 J."""
    count = len(result.rows)
    length = 1.0 + 0.2 * (1.0 - np.abs(np.linspace(-1.0, 1.0, count)))
    one = with_columns(result, f_cable_1=np.full(count, 50.0), l_cable_1=length)
    assert metric_values(["energy.cable_1"], one, None)["energy.cable_1"] == pytest.approx(20.0)
    energies = metric_values(expand_wildcards(["energy.*"], one.experiment.robot), one, None)
    assert sum(energies.values()) == pytest.approx(metric_values(["energy"], one, None)["energy"])


def test_margins_are_distances_to_the_force_limits(result: Result) -> None:
    forces = np.stack([result[f"f.cable_{k}"] for k in (1, 2, 3, 4)])
    found = metric_values(["margin.upper", "margin.lower"], result, None)
    assert found["margin.upper"] == 100.0 - forces.max()
    assert found["margin.lower"] == forces.min() - 10.0


def test_a_passive_spring_is_not_included_in_margins() -> None:
    spring = {"kind": "passive_spring", "K": 40.0, "l0": 0.4}
    passive = {"f_min": 0.0, "f_max": 0.0, "model": spring}
    settings = SETTINGS | {f"muscles.cable_4.{key}": value for key, value in passive.items()}
    result = simulate(Experiment.load(PLANAR, settings), coupling="direct")
    active = np.stack([result[f"f.cable_{k}"] for k in (1, 2, 3)])
    found = metric_values(["margin.upper", "margin.lower"], result, None)
    assert found["margin.upper"] == 100.0 - active.max()
    assert found["margin.lower"] == active.min() - 10.0
    lines = [line for line in result.describe().splitlines() if ".cable_" in line]
    assert [".cable_4" in line for line in lines] == ["limits" not in line for line in lines]


def test_loop_margins_are_the_smallest_of_all_loops() -> None:
    settings = {**SETTINGS, "controller.kp.joint_2": 400.0}
    result = simulate(Experiment.load(PLANAR, settings), coupling="direct")
    loops = [margins(kp, 90.0, 0.01) for kp in (2000.0, 400.0)]
    found = metric_values(["margin.phase", "margin.gain", "margin.delay"], result, None)
    assert list(found.values()) == [
        min(getattr(loop, name) for loop in loops)
        for name in ("phase_margin", "gain_margin", "delay_margin")
    ]


def test_stiffness_is_the_torque_gradient_at_constant_forces(result: Result) -> None:
    """It equals d/dq of G + L'f, computed with central differences in every row."""
    dynamics = DartDynamics(result.experiment.robot)
    q = result.columns(["q.joint_1", "q.joint_2"])
    f = result.columns([f"f.cable_{k}" for k in (1, 2, 3, 4)])
    lowest = np.inf
    for pose, forces in zip(q, f, strict=True):
        columns = []
        for axis in np.eye(2):
            ends = [
                dynamics.gravity(pose + h * axis).copy()
                + dynamics.muscle_jacobian(pose + h * axis).T @ forces
                for h in (1e-5, -1e-5)
            ]
            columns.append((ends[0] - ends[1]) / 2e-5)
        K = np.stack(columns, axis=1)
        lowest = min(lowest, float(np.linalg.eigvalsh(0.5 * (K + K.T))[0]))
    found = metric_values(["stiffness.min"], result, None)["stiffness.min"]
    assert found == pytest.approx(lowest, rel=1e-5)


def test_wrench_closure_is_a_fraction_of_the_workspace() -> None:
    """It is 1 with the paper's four cables, and 0 if the cables pull only in one direction."""
    box = Box(lower=(-0.4, -0.4), upper=(0.4, 0.4), points=3)
    good = simulate(Experiment.load(PLANAR, SETTINGS), coupling="direct")
    assert metric_values(["wrench_closure"], good, box) == {"wrench_closure": 1.0}
    changes = {
        f"robot.muscles.cable_{k}.points[{p}].position[0]": x
        for k in (3, 4)
        for p, x in ((0, 0.5 * k), (1, 0.1))
    }
    one_sided = replace(good, experiment=Experiment.load(PLANAR, {**SETTINGS, **changes}))
    assert metric_values(["wrench_closure"], one_sided, box) == {"wrench_closure": 0.0}


def test_a_workspace_without_limits_is_rejected_with_a_hint(result: Result) -> None:
    if all(np.isfinite([c.lower, c.upper]).all() for c in result.experiment.robot.coordinates):
        pytest.skip("the robot has limits")
    with pytest.raises(InputError, match=r"\[workspace\]"):
        metric_values(["wrench_closure"], result, None)


def test_every_metric_has_a_value_and_a_unit(result: Result) -> None:
    box = Box(lower=(-0.4, -0.4), upper=(0.4, 0.4), points=2)
    values = metric_values(METRICS, result, box)
    assert [name for name, value in values.items() if value is None] == ["missed"]  # no hardware
    units = metric_units(METRICS, "rad")
    assert units["tracking.rms"] == "rad"
    assert units["energy"] == "J"


def test_tracking_metrics_equal_the_summary(result: Result) -> None:
    found = metric_values(["tracking.rms", "tracking.max"], result, None)
    tracking = result.summary["tracking"]
    assert list(found.values()) == [tracking["rms"], tracking["max"]]


@pytest.mark.parametrize("name", ["force", "force.peak.", "tracking.rms.cable_1", "force.peak.x.y"])
def test_an_unknown_metric_is_rejected(name: str) -> None:
    with pytest.raises(UnknownNameError):
        expand_wildcards([name], Experiment.load(Path(PLANAR)).robot)
