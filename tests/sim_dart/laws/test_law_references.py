"""Muscle laws compared with reference values of OpenSim."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.muscle_bench import HILL, Bench

pytestmark = pytest.mark.native


def _table(shared: Path, name: str) -> Any:
    return json.loads((shared / "reference" / "muscles" / f"{name}.json").read_text())


@pytest.mark.parametrize(
    ("theirs", "ours"),
    [
        ("active_force_length", "active_force_length"),
        ("force_velocity", "force_velocity"),
        ("tendon_force_length", "tendon_force_length"),
        ("fiber_force_length", "passive_force_length"),
    ],
)
def test_millard_curves(shared: Path, theirs: str, ours: Any) -> None:
    table = _table(shared, "millard2012_curves")[theirs]
    bench = Bench(("hill_millard2012", HILL | {"active_minimum": 0.1}))
    x, y, slope = (np.array(table[key]) for key in ("x", "y", "dydx"))
    np.testing.assert_allclose(bench.curve(ours, x), y, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(bench.curve(ours, x, slope=True), slope, rtol=1e-11, atol=1e-12)


def test_de_groote_muscle_with_rigid_tendon(shared: Path) -> None:
    parameters = HILL | {"pennation_at_optimal": 0.1}
    bench = Bench(("hill_degroote2016", parameters))
    rows = _table(shared, "degroote2016_rigid")["rows"]
    for row in rows:
        found = bench.tension(row["mtu_length"], row["mtu_speed"], 0.0, [row["activation"]])
        assert found == pytest.approx(row["tendon_force"], rel=1e-12, abs=1e-10)
    fibre = np.array([row["fiber_length"] for row in rows]) / 0.1
    speed = np.array([row["fiber_velocity"] for row in rows]) / (10.0 * 0.1)
    for x, curve, key in (
        (fibre, "active_force_length", "active_force_length_mult"),
        (speed, "force_velocity", "force_velocity_mult"),
        (fibre, "passive_force_length", "passive_mult"),
    ):
        y = bench.curve(curve, x)
        np.testing.assert_allclose(y, [row[key] for row in rows], rtol=1e-12, atol=1e-15)


def test_blankevoort_ligament(shared: Path) -> None:
    parameters = {"linear_stiffness": 5000.0, "slack_length": 0.1}
    bench = Bench(("ligament_blankevoort1991", parameters))
    for row in _table(shared, "blankevoort1991")["rows"]:
        found = bench.tension(row["length"], row["speed"], 0.0)
        assert found == pytest.approx(row["total"], rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("kind", ["hill_millard2012", "hill_thelen2003"])
def test_first_order_activation(shared: Path, kind: str) -> None:
    table = _table(shared, "activation_first_order_millard")
    times = {
        "activation_time_constant": table["tau_act"],
        "deactivation_time_constant": table["tau_deact"],
        "minimum_activation": table["amin"],
    }
    bench = Bench((kind, HILL | times))
    for row in table["rows"]:
        found = bench.state_rates(0.3, 0.0, row["u"], [row["a"]])[0]
        assert found == pytest.approx(row["dadt"], rel=1e-13, abs=1e-13)
