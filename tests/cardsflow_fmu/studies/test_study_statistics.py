"""Distributions, worst cases and sensitivities against closed forms."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from small_studies import small_study

from cardsflow_fmu.studies.outcome import Outcome
from cardsflow_fmu.studies.sampling import expand
from cardsflow_fmu.studies.statistics import (
    Collected,
    collect,
    distributions,
    sensitivities,
    worst_runs,
)
from cardsflow_fmu.studies.study import Study
from cardsflow_fmu.studies.table import columns_of

TWO = """
[[vary]]
name = "a"
path = "controller.kp"
uniform = [1.0, 2.0]
[[vary]]
name = "b"
path = "controller.kd"
uniform = [1.0, 2.0]
"""


def collected(study: Study, f: Callable[[float, float], float]) -> Collected:
    rows = ((run, Outcome({"force.peak": f(*run.values.values())})) for run in expand(study, "x"))
    return collect(columns_of(study), rows)


def test_sobols_indices_of_a_sum_are_its_parts_of_the_variance(tmp_path: Path) -> None:
    """Y = 3 a + b: variances 9 : 1; nothing is made together."""
    study = small_study(
        tmp_path, TWO, "sampler = 'sensitivity'\ncount = 512\nmetrics=['force.peak']"
    )
    found = sensitivities(study, collected(study, lambda a, b: 3.0 * a + b))["force.peak"]
    assert found["a"]["first"] == pytest.approx(0.9, abs=0.01)
    assert found["b"]["total"] == pytest.approx(0.1, abs=0.01)


def test_sobols_indices_of_a_product_have_a_part_that_is_made_together(tmp_path: Path) -> None:
    """Y = (a - 3/2)(b - 3/2): no variation alone does anything."""
    study = small_study(
        tmp_path, TWO, "sampler = 'sensitivity'\ncount = 8192\nmetrics=['force.peak']"
    )
    f = sensitivities(study, collected(study, lambda a, b: (a - 1.5) * (b - 1.5)))["force.peak"]
    assert f["a"]["first"] == pytest.approx(0.0, abs=0.05)
    assert f["a"]["total"] == pytest.approx(1.0, abs=0.05)


def test_ranks_tell_the_direction(tmp_path: Path) -> None:
    study = small_study(tmp_path, TWO, "count = 64\nmetrics=['force.peak']")
    found = sensitivities(study, collected(study, lambda a, b: float(np.exp(-a))))["force.peak"]
    assert found["a"]["rank"] == pytest.approx(-1.0)
    assert abs(found["b"]["rank"]) < 0.3


def test_worst_is_large_unless_large_is_good() -> None:
    numbers = np.array([3.0, np.nan, 1.0, 2.0])
    data = Collected(["w", "x", "y", "z"], {}, {"force.peak": numbers, "margin.upper": numbers})
    assert worst_runs(data) == {"force.peak": [0, 3, 2], "margin.upper": [2, 3, 0]}


def test_distributions_leave_failed_runs_out() -> None:
    values = np.array([np.nan, *np.arange(101.0)])
    found = distributions(Collected([], {}, {"energy": values}))["energy"]
    assert found == {
        "count": 101,
        "min": 0.0,
        "mean": 50.0,
        "max": 100.0,
        "deviation": pytest.approx(np.sqrt((101**2 - 1) / 12.0)),
        "p05": 5.0,
        "median": 50.0,
        "p95": 95.0,
    }


def test_errors_are_counted_and_their_number_is_bounded(tmp_path: Path) -> None:
    study = small_study(tmp_path, TWO, "count = 200\nmetrics=['force.peak']")
    rows = ((run, Outcome({}, f"at {run.index}")) for run in expand(study, "x"))
    failures = collect(columns_of(study), rows).failures
    assert sum(failures.values()) == 200
    assert len(failures) <= 51
