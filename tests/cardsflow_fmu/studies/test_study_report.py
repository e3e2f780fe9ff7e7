"""Report of a study: best runs and heat maps over two variations."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from support.small_studies import run_here, small_study

from cardsflow_fmu.studies import StudyResult
from cardsflow_fmu.studies.analysis.plots import heat_map, mean_cells

GAINS = """
[[vary]]
name = "kp"
path = "controller.kp"
values = [500.0, 1000.0, 2000.0]
[[vary]]
name = "kd"
path = "controller.kd"
values = [40.0, 80.0]
"""


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> StudyResult:
    folder = tmp_path_factory.mktemp("swept")
    top = "sampler = 'grid'\nmetrics = ['tracking.rms', 'force.peak']"
    return run_here(small_study(folder, GAINS, top), folder / "out")


@pytest.mark.slow
def test_the_best_run_has_the_smallest_error(swept: StudyResult) -> None:
    errors = {run.index: outcome.metrics["tracking.rms"] for run, outcome in swept.rows()}
    assert len(errors) == 6
    index = min(errors, key=errors.__getitem__)
    best = json.loads(swept.files["summary.json"].read_text())["best_by_metric"]["tracking.rms"]
    assert (best["run"], best["value"]) == (index, errors[index])
    page = swept.files["report.html"].read_text()
    assert page.index("<h2>Best runs</h2>") < page.index("<h2>Distributions</h2>")
    assert f"controller.kp = {best['settings']['controller.kp']:.6g}" in page
    assert f"--only {best['hash'][:8]}" in page


@pytest.mark.slow
def test_a_study_of_two_parameters_has_a_heat_map_for_each_metric(swept: StudyResult) -> None:
    page = swept.files["report.html"].read_text()
    start = page.index("<h2>Over kp and kd</h2>")
    maps = page[start : page.index("<h2>Distributions</h2>")]
    assert maps.count("<svg") == 2
    texts = re.findall(r"<text[^>]*>([^<]*)</text>", maps)
    for text in ("kp", "kd", "500", "1000", "2000", "40", "80", "tracking.rms [rad]"):
        assert text in texts


@pytest.mark.slow
def test_a_study_of_one_parameter_has_no_heat_map(tmp_path: Path) -> None:
    page = run_here(small_study(tmp_path), tmp_path / "out").files["report.html"].read_text()
    assert "<h2>Best runs</h2>" in page
    assert "<h2>Over" not in page


def test_cells_are_means_of_successful_runs() -> None:
    x = np.array([1.0, 1.0, 2.0, 2.0, 2.0])
    y = np.array([3.0, 3.0, 3.0, 4.0, 4.0])
    values = np.array([5.0, 7.0, 9.0, 1.0, np.nan])
    np.testing.assert_array_equal(mean_cells(x, y, values), [[6.0, 9.0], [np.nan, 1.0]])


@pytest.mark.slow
@pytest.mark.parametrize("count", [40, 30_000])
def test_scattered_runs_are_small_figures_with_dots(count: int) -> None:
    x, y = np.random.default_rng(0).random((2, count))  # as a grid, up to 900 million cells
    text = heat_map(("a", "b"), x, y, ("tracking.rms", "rad"), np.where(x < 0.1, np.nan, x + y))
    if count == 40:
        assert len(re.findall(r"<use [^>]*fill: #", text)) == np.count_nonzero(x >= 0.1)
    assert len(text) < 300_000
