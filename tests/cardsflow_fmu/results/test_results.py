"""Results as tables, in notebooks, comparisons, figures and reports."""

from __future__ import annotations

import json
import re
import shutil
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.browser import opened_browser
from support.cases import sample_cases
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, Result, run
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.results.compare import compare, compare_results
from cardsflow_fmu.results.report.figures import figure_of, plot
from cardsflow_fmu.results.report.page import report, report_page
from cardsflow_fmu.results.report.panels import KINDS, all_panels, panels_of
from cardsflow_fmu.results.saved_run import read_results
from cardsflow_fmu.simulation.result import SystemResult


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    folder = tmp_path_factory.mktemp("run")
    return folder, run(Experiment.load(PLANAR_2R, {"run.duration": 0.3}), folder, coupling="direct")


def table(rows: Any, *names: str) -> SystemResult:
    return SystemResult(("time", *names), np.array(rows, float), {}, {})


# Pandas, notebooks


@pytest.mark.extra("pandas")
def test_result_is_converted_to_a_pandas_data_frame(
    finished: tuple[Path, Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    result = finished[1]
    frame = result.to_pandas()
    assert frame.index.name == "time"
    np.testing.assert_array_equal(frame.index, result["time"])
    np.testing.assert_array_equal(frame["q.joint_1"], result["q.joint_1"])
    assert frame.attrs["units"]["f.cable_1"] == "N"
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match="uv sync --extra pandas"):
        result.to_pandas()


@pytest.mark.slow
def test_notebook_shows_summary_and_figure(finished: tuple[Path, Result]) -> None:
    html = finished[1]._repr_html_()
    assert html.count("<svg") == 1
    for words in ("planar_2r", "q.joint_1", "f.cable_4", "301 rows"):
        assert words in html
    assert "<p>" in table(np.empty((0, 2)), "x")._repr_html_()


def test_unpacked_robot_files_are_deleted_with_the_result(finished: tuple[Path, Result]) -> None:
    loaded = Result.load(finished[0])
    path = loaded.experiment.robot_path
    assert path.is_file()
    np.testing.assert_array_equal(loaded.solve_times, finished[1].solve_times)
    assert len(loaded.solve_times) == loaded.summary["ticks"]
    del loaded
    assert not path.parent.exists()


# compare


def test_equal_results_are_equal(finished: tuple[Path, Result]) -> None:
    comparison = compare(finished[0], finished[0] / "results.csv")
    assert comparison["equal"]
    assert set(comparison["columns"]) == set(finished[1].names) - {"time"}
    assert all(c["largest"] == 0.0 for c in comparison["columns"].values())


def test_comparison_in_blocks_of_rows_matches_comparison_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    time, rng = np.arange(100) * 0.1, np.random.default_rng(3)
    a, b = (table(np.column_stack([time[k:], rng.random((100 - k, 2))]), "x", "y") for k in (0, 7))
    a.rows[50, 1] = np.nan
    at_once = compare_results(a, b, 0.5)
    monkeypatch.setattr("cardsflow_fmu.results.compare._BLOCK_SIZE", 9)
    assert compare_results(a, b, 0.5) == at_once
    assert at_once["columns"]["x"] | {"unit": ""} == {
        "largest": None,
        "at": time[50],
        "beyond": True,
        "unit": "",
    }


@pytest.mark.parametrize(
    ("atol", "rtol", "equal"),
    [
        (0.0, 0.0, False),
        (0.25, 0.0, True),
        (0.2, 0.0, False),
        (0.0, 0.03, True),
        (0.1, 0.01, False),
    ],
)
def test_comparison_uses_absolute_and_relative_tolerances(
    atol: float, rtol: float, equal: bool
) -> None:
    a, b = table([[0, 10.0], [1, 10.25]], "x"), table([[0, 10.0], [1, 10.0]], "x")
    comparison = compare_results(a, b, atol, rtol)
    assert comparison["equal"] is equal
    assert comparison["columns"]["x"] == {
        "largest": 0.25,
        "at": 1.0,
        "beyond": not equal,
        "unit": "",
    }


def test_nan_and_infinity_only_equal_themselves() -> None:
    a = table([[0, np.nan, np.inf, np.inf, 1], [1, 0, 0, 0, 1]], "p", "q", "r", "s")
    b = table([[0, np.nan, np.inf, -np.inf, np.nan], [1, 0, 0, 0, 1]], "p", "q", "r", "s")
    comparison = compare_results(a, b, 1e300)
    assert comparison["beyond"] == ["r", "s"]
    assert comparison["columns"]["s"]["largest"] is None


def test_missing_columns_and_rows_are_reported(tmp_path: Path, cardsflow: CommandLine) -> None:
    (tmp_path / "a.csv").write_text("time,x,y\n0.0,1.0,2.0\n0.1,1.0,2.0\n0.2,1.0,2.0\n")
    (tmp_path / "b.csv").write_text("time,x,z\n0.1,1.5,2.0\n0.2,1.0,2.0\n0.3,1.0,2.0\n")
    words = ["compare", tmp_path / "a.csv", tmp_path / "b.csv", "--atol", "1"]
    code, out, _ = cardsflow(*words, "--json")
    assert code == 1
    comparison = json.loads(out)
    assert comparison["missing"] == {"first": ["z"], "second": ["y"]}
    assert comparison["rows"] == {"first": 3, "second": 3, "common": 2}
    assert comparison["columns"]["x"]["largest"] == 0.5
    code, text, _ = cardsflow(*words)
    assert code == 1
    for line in ("missing in the first: z", "missing in the second: y", "2 of them at the same"):
        assert line in text
    cardsflow.error_line(*words, "--columns", "nothing.*")
    cardsflow.error_line("compare", tmp_path / "a.csv", tmp_path / "none.csv")
    cardsflow.error_line(*words[:3], "--atol", "-1")
    assert cardsflow(*words[:3], "--rtol", "1e308")[2] == ""
    assert cardsflow("compare", words[1], words[1])[0] == 0
    refused = cardsflow.error_line("plot", tmp_path / "nowhere")
    assert "nowhere: has no results of a run" in refused


@pytest.mark.parametrize("command", ["view", "plot", "report"])
def test_results_before_a_run_are_rejected_with_the_command_to_run(
    command: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    """The experiment, its folder, and its future results folder."""
    file = tmp_path / "experiment.toml"
    shutil.copy(EXAMPLES / "planar_2r/experiment.toml", file)
    for path in (file, tmp_path, tmp_path / "results"):
        said = cardsflow.error_line(command, path)
        assert f"{path}: has no results of a run; run the experiment first" in said
        assert said.endswith(f": cardsflow run {file}\n")
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "results.csv").write_text("time\n0.0\n")
    said = cardsflow.error_line(command, tmp_path)
    assert said.endswith(f"has no results of a run; specify {tmp_path / 'results'}\n")


# plot


ABSENT = {"torques", "estimate", "loads", "innovation"}
"""Panels of joint motors and of an estimator; these runs have neither."""


def test_every_kind_of_figure_shows_its_signals(finished: tuple[Path, Result]) -> None:
    panels = all_panels(finished[1])
    assert set(panels) == set(KINDS) - ABSENT
    (forces,) = panels["forces"]
    assert [c.name for c in forces.curves] == [f"f.cable_{k}" for k in (1, 2, 3, 4)]
    (errors,) = panels["errors"]
    expected = finished[1]["q.joint_2"] - finished[1]["q_d.joint_2"]
    np.testing.assert_array_equal(errors.curves[1].values, expected)


def test_moment_arms_are_derivatives_of_the_lengths(finished: tuple[Path, Result]) -> None:
    """Along the motion, dl = sum_j dl/dq_j dq_j, with an error of third order."""
    result = finished[1]
    arms = {p.label.split(",")[1].split()[0]: p for p in KINDS["moment_arms"](result)}
    expected = np.zeros((len(result.rows) - 2, 4))
    for joint, panel in arms.items():
        for curve in panel.curves:
            k = int(curve.name[-1]) - 1
            q = result[f"q.{joint}"]
            expected[:, k] -= curve.values[1:-1] * (q[2:] - q[:-2])
    lengths = result.columns([f"l.cable_{k}" for k in (1, 2, 3, 4)])
    change = lengths[2:] - lengths[:-2]
    assert np.abs(change).max() > 1e-5
    np.testing.assert_allclose(expected, change, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("file", "head"), sample_cases([("a.png", b"\x89PNG"), ("a.svg", b"<?xml"), ("a.pdf", b"%PDF")])
)
def test_figures_are_written(
    finished: tuple[Path, Result], tmp_path: Path, file: str, head: bytes
) -> None:
    words = ["plot", str(finished[0]), "-o", str(tmp_path / file)]
    assert main(words) == 0
    first = (tmp_path / file).read_bytes()
    assert first.startswith(head)
    assert main(words) == 0
    assert (tmp_path / file).read_bytes() == first


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["-o", "a.gif"], "no kind of figure 'gif'"),
        (["--panels", "force"], "no figure 'force'; did you mean 'forces'"),
        (["--columns", "q.joint_9"], "no column 'q.joint_9'; did you mean 'q.joint_"),
    ],
)
def test_invalid_plot_options_are_reported(
    finished: tuple[Path, Result], cardsflow: CommandLine, words: list[str], says: str
) -> None:
    assert says in cardsflow.error_line("plot", finished[0], *words)


def test_columns_are_grouped_by_unit(finished: tuple[Path, Result]) -> None:
    panels = panels_of(finished[1], columns=["q.*", "f.cable_1"])
    assert [(p.label, len(p.curves)) for p in panels] == [("[rad]", 2), ("[N]", 1)]
    assert len(figure_of(finished[1], ["forces"], ["q.*"]).axes) == 2
    with pytest.raises(InputError, match="no data for 'moment_arms'"):
        panels_of(table([[0, 1]], "x"), ["moment_arms"])
    with pytest.raises(InputError, match="no rows"):
        panels_of(table(np.empty((0, 2)), "x"))


@pytest.mark.slow
def test_table_without_a_results_folder_is_drawn(tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("time,a.b,c\n0.0,1.0,2.0\n0.1,1.0,2.0\n")
    assert plot(read_results(tmp_path / "x.csv"), tmp_path / "x.png").stat().st_size > 1000


# report


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the report of a run of 30 s with eleven muscles."""
    folder = tmp_path_factory.mktemp("flower")
    settings = {"run.duration": 30.0, "run.step": 0.005, "controller.period": 0.005}
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm", settings)
    run(experiment, folder / "out", coupling="direct")
    return report(folder / "out", folder / "the report.html")


@pytest.mark.slow
def test_report_contains_all_sections(reported: Path) -> None:
    page = reported.read_text()
    assert len(page) < 3_000_000
    for words in ("Summary", "Replay", "Figures", "Robot", "Experiment", "Versions"):
        assert f"<h2>{words}</h2>" in page
    assert page.count("<svg") == len(set(KINDS) - ABSENT)
    for words in ("&quot;flower&quot;", "upper_arm_left", "dartpy", "moment arms"):
        assert words in page
    # names of XML vocabularies, which are not addresses to open
    assert set(re.findall(r"(?:https?|wss?|ftp)://[^\s\"'&<>]+", page)) <= {
        "http://www.w3.org/2000/svg",
        "http://www.w3.org/1999/xlink",
    }


@pytest.mark.browser
def test_report_opens_from_disk_without_a_network(reported: Path, tmp_path: Path) -> None:
    with opened_browser(tmp_path) as page:
        begin = time.perf_counter()
        page.open(reported.as_uri(), offline=True)
        page.wait_for("document.readyState === 'complete' && document.querySelector('iframe')")
        for scheme, colour in (("dark", "rgb(230, 233, 238)"), ("light", "rgb(35, 39, 47)")):
            media = [{"name": "prefers-color-scheme", "value": scheme}]
            page.send("Emulation.setEmulatedMedia", features=media)
            assert page.evaluate("getComputedStyle(document.body).color") == colour
        page.evaluate("document.querySelector('iframe').scrollIntoView({block: 'center'})")
        box = page.evaluate(
            "(r => [r.x, r.y, r.width, r.height].map(Math.round))"
            "(document.querySelector('iframe').getBoundingClientRect())"
        )
        x, y, width, height = box
        part = (slice(y + 100, y + height - 100), slice(x + 60, x + width - 220))
        while True:
            image = page.screenshot()[part]
            if np.count_nonzero(np.ptp(image, axis=2) > 60) > 500:
                break
            assert time.perf_counter() - begin < 300.0
        figures = page.evaluate("document.querySelectorAll('figure svg path').length")
        assert figures > 50
        assert page.errors == []
        assert [url for url in page.requests if not url.startswith(("about:", "data:"))] == [
            reported.as_uri()
        ]


@pytest.mark.slow
def test_report_states_that_a_run_is_incomplete(finished: tuple[Path, Result]) -> None:
    result = Result.load(finished[0])
    result.summary |= {"status": "incomplete", "error": "<b>gone</b>"}
    page = report_page(result)
    assert "Incomplete run: &lt;b&gt;gone&lt;/b&gt;" in page
    assert "<b>gone" not in page


@pytest.mark.slow
def test_report_begins_with_the_verdict_and_the_replay(finished: tuple[Path, Result]) -> None:
    result = Result.load(finished[0])
    tracking = result.summary["tracking"]
    page = report_page(result)
    verdict = re.search(r'<p class="verdict good">(.*)</p>', page)
    assert f"{tracking['rms']:.3g} rad" in verdict[1]
    assert f"0 of {result.summary['ticks']} ticks infeasible" in verdict[1]
    unfolded = re.sub(r"<details>.*?</details>", "", page, flags=re.DOTALL)
    assert "<table" not in unfolded
    places = [page.index(words) for words in ("<h1>", '"verdict', "<iframe", "<figure", "<table")]
    assert places == sorted(places)

    result.summary |= {"warnings": ["581 of 800 ticks infeasible"], "infeasible_ticks": 581}
    page = report_page(result)
    assert "verdict good" not in page
    assert page.index("Warning: 581 of 800") < page.index('class="verdict"') < page.index("<iframe")


def test_help_has_an_example(cardsflow: CommandLine) -> None:
    for name in ("plot", "compare", "report"):
        assert f"example:\n  cardsflow {name} " in cardsflow(name, "--help")[1]
