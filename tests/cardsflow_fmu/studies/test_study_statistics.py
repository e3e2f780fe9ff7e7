"""Distributions, worst cases and sensitivities, compared with closed forms."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats
from support.small_studies import small_study

from cardsflow_fmu.studies.analysis.plots import histogram
from cardsflow_fmu.studies.analysis.statistics import (
    Collected,
    collect,
    distributions,
    rank_runs,
    sensitivities,
    sobol_indices,
    variance_share,
)
from cardsflow_fmu.studies.analysis.table import columns_of
from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.sampling import expand
from cardsflow_fmu.studies.definition.study import Study
from cardsflow_fmu.studies.run import summary_text

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


def test_sobol_indices_of_a_sum_are_its_shares_of_the_variance(tmp_path: Path) -> None:
    """Y = 3 a + b has variances 9 : 1 and no interaction."""
    study = small_study(
        tmp_path, TWO, "sampler = 'sensitivity'\ncount = 512\nmetrics=['force.peak']"
    )
    found = sensitivities(study, collected(study, lambda a, b: 3.0 * a + b))["force.peak"]
    assert found["a"]["first"] == pytest.approx(0.9, abs=0.01)
    assert found["b"]["total"] == pytest.approx(0.1, abs=0.01)


@pytest.mark.slow
def test_sobol_indices_of_a_product_include_the_interaction(tmp_path: Path) -> None:
    """Y = (a - 3/2)(b - 3/2) has no first-order effects."""
    study = small_study(
        tmp_path, TWO, "sampler = 'sensitivity'\ncount = 8192\nmetrics=['force.peak']"
    )
    f = sensitivities(study, collected(study, lambda a, b: (a - 1.5) * (b - 1.5)))["force.peak"]
    assert f["a"]["first"] == pytest.approx(0.0, abs=0.05)
    assert f["a"]["total"] == pytest.approx(1.0, abs=0.05)


def test_sobol_indices_equal_scipy() -> None:
    f = np.random.default_rng(3).normal(size=(5, 64))
    f[2:] += f[:1]
    answers: Any = {"f_A": f[:1], "f_B": f[1:2], "f_AB": f[2:, np.newaxis, :]}
    expected = stats.sobol_indices(func=answers, n=64)
    first, total = sobol_indices(f)
    assert np.allclose(first, np.ravel(expected.first_order), rtol=1e-12, atol=1e-12)
    assert np.allclose(total, np.ravel(expected.total_order), rtol=1e-12, atol=1e-12)


def test_points_with_a_failed_run_are_omitted(tmp_path: Path) -> None:
    study = small_study(
        tmp_path, TWO, "sampler = 'sensitivity'\ncount = 512\nmetrics=['force.peak']"
    )
    data = collected(study, lambda a, b: 3.0 * a + b)
    data.metrics["force.peak"][[7, 600, 1300]] = np.nan
    found = sensitivities(study, data)["force.peak"]
    assert found["a"]["first"] == pytest.approx(0.9, abs=0.02)
    data.metrics["force.peak"][:508] = np.nan
    assert sensitivities(study, data) == {}


def test_ranks_show_the_direction(tmp_path: Path) -> None:
    study = small_study(tmp_path, TWO, "count = 64\nmetrics=['force.peak']")
    found = sensitivities(study, collected(study, lambda a, b: float(np.exp(-a))))["force.peak"]
    assert found["a"]["rank"] == pytest.approx(-1.0)
    assert abs(found["b"]["rank"]) < 0.3


def test_shares_of_variance_detect_symmetric_influences(tmp_path: Path) -> None:
    """Y = (a - 3/2)² has rank correlation 0; share in K groups 1 - 5 (1 - 1/K²) / K² - 1/K⁴."""
    study = small_study(tmp_path, TWO, "count = 1000\nsampler = 'sobol'\nmetrics=['force.peak']")
    found = sensitivities(study, collected(study, lambda a, b: (a - 1.5) ** 2))["force.peak"]
    assert abs(found["a"]["rank"]) < 0.05
    assert found["a"]["share"] == pytest.approx(1.0 - 0.05 * 0.99 - 1e-4, abs=5e-3)
    assert found["b"]["share"] < 0.02


def test_shares_of_variance_are_first_order_indices() -> None:
    """Y = 3 a + b with few or many values has variances 9 : 1."""
    random = np.random.default_rng(7)
    for values in (random.random((20_000, 2)), random.integers(0, 5, (20_000, 2)) / 4.0):
        a, b = values.T
        assert variance_share(a, 3.0 * a + b) == pytest.approx(0.9, abs=0.02)
        assert variance_share(b, 3.0 * a + b) == pytest.approx(0.1, abs=0.02)


def test_rank_runs_have_large_values_unless_large_is_good() -> None:
    numbers = np.array([3.0, np.nan, 1.0, 2.0])
    data = Collected(["w", "x", "y", "z"], {}, {"force.peak": numbers, "margin.upper": numbers})
    assert rank_runs(data) == {"force.peak": [0, 3, 2], "margin.upper": [2, 3, 0]}


def test_infinities_are_null_in_the_summary() -> None:
    numbers = np.array([np.inf, np.inf, 1.0])
    data = Collected(["x", "y", "z"], {}, {"margin.gain": numbers})
    assert rank_runs(data) == {"margin.gain": [2, 0, 1]}
    text = summary_text({"history": [float("nan"), 1.0], "worst": ({"value": float("inf")},)})
    assert json.loads(text) == {"history": [None, 1.0], "worst": [{"value": None}]}


@pytest.mark.slow
@pytest.mark.parametrize("values", [[1.0, 1.0 + 2e-16], [0.0, 5e-324], [-1e90, 1e90], [3.0, 3.0]])
def test_histograms_support_all_finite_values(values: list[float]) -> None:
    """This includes values that differ only by rounding errors."""
    assert "<svg" in histogram("x", "N", np.array(values))


def test_distributions_omit_failed_runs() -> None:
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
