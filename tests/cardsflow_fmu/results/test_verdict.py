"""Warnings of a run are printed first: in output, summary, report, replay; exit codes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R
from support.run_modes import RUN_MODES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.cosim.divergence import column_limits, row_error
from cardsflow_fmu.results.report.figures import figure_title
from cardsflow_fmu.results.report.page import report_page
from cardsflow_fmu.results.saved_run import open_results
from cardsflow_fmu.results.verdict import NOT_FOLLOWED, failure, problems
from cardsflow_fmu.results.viewer.view import notes
from cardsflow_fmu.simulation.run import RunError

FAILING = {f"muscles.cable_{k}.f_max": 15.0 for k in range(1, 5)} | {"run.duration": 0.2}
WEAK: dict[str, Any] = FAILING | {"run.accept": "any"}


def words(settings: dict[str, Any]) -> list[str]:
    return [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]


@pytest.mark.parametrize("compute", ["python", "c"])
def test_output_of_a_run_begins_with_warnings(
    compute: str, cardsflow: CommandLine, tmp_path: Path
) -> None:
    engine = ("--compute", compute, "--coupling", "direct")
    code, out, _ = cardsflow("run", PLANAR_2R, *engine, *words(WEAK), "-o", tmp_path)
    assert code == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["infeasible_ticks"] > 0
    joint = max(summary["slack"]["per_signal"].items(), key=lambda row: row[1]["max"])
    begin = f"{summary['infeasible_ticks']} of {summary['ticks']} ticks infeasible, from t = "
    assert out.startswith(f"WARNING: {begin}")
    first = f"torque shortfall up to {joint[1]['max']:.3g} N.m at {joint[0][len('slack.') :]}"
    assert first in out.splitlines()[0]
    assert summary["warnings"][0].startswith(begin)
    assert "\033" not in out  # no terminal


def test_failed_run_exits_with_1_unless_poor_tracking_is_allowed(
    cardsflow: CommandLine, tmp_path: Path
) -> None:
    command = ("run", PLANAR_2R, "--coupling", "direct", "-o", tmp_path)
    code, out, _ = cardsflow(*command, *words(FAILING))
    assert code == 1
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["status"], summary["failure"]) == ("failed", NOT_FOLLOWED)
    assert out.startswith(f"FAILED: {NOT_FOLLOWED}\nWARNING: {summary['warnings'][0]}")
    code, out, err = cardsflow(*command, *words(FAILING), "--json")
    assert (code, json.loads(out)["failure"]) == (1, summary["failure"])
    assert f"FAILED: {summary['failure']}" in err
    code, out, _ = cardsflow(*command, *words(FAILING), "--allow-poor-tracking")
    assert (code, "FAILED" in out) == (0, False)


@pytest.mark.parametrize(
    "settings", [{"controller.kp": 1e12}, {"plant.mass_scale": 1e9}], ids=["gain", "mass"]
)
def test_run_that_does_not_follow_its_reference_fails(
    settings: dict[str, float], tmp_path: Path
) -> None:
    experiment = Experiment.load(PLANAR_2R, settings | {"run.duration": 2.0})
    result = run(experiment, tmp_path, coupling="direct")
    assert (result.summary["status"], result.summary["failure"]) == ("failed", NOT_FOLLOWED)
    assert result.complete
    line = f"FAILED: {NOT_FOLLOWED}"
    assert notes(result)[0] == line
    page = report_page(result)
    assert page.index(line) < page.index("Summary")
    assert figure_title(result) == line
    with open_results(tmp_path) as opened:
        assert opened.summary["status"] == "failed"


@pytest.mark.parametrize(
    ("error", "line", "failed"),
    [(0.04, None, None), (0.06, "tracked poorly", None), (0.15, "not tracked", NOT_FOLLOWED)],
)
def test_tracking_errors_above_a_fifth_of_the_range_are_a_warning(
    error: float, line: str | None, failed: str | None
) -> None:
    summary = tracking_summary(error, 0.25)
    lines = problems(summary)
    assert [f"the reference is {line}" in text for text in lines] == [True] * (line is not None)
    assert failure(summary) == failed


def test_only_shares_above_the_threshold_fail() -> None:
    assert failure({"ticks": 100, "infeasible_ticks": 1}) is None
    assert failure({"ticks": 100, "infeasible_ticks": 2}) == "2 of 100 ticks infeasible"
    assert failure({"ticks": 100, "not_converged_ticks": 2}) == "2 of 100 ticks not converged"


@pytest.mark.slow
def test_strict_runs_with_warnings_exit_with_3(cardsflow: CommandLine, tmp_path: Path) -> None:
    common = ("run", PLANAR_2R, "--coupling", "direct", "--strict", "-o", tmp_path)
    assert cardsflow(*common, *words(WEAK))[0] == 3
    assert cardsflow(*common, "--set", "run.duration=0.05")[0] == 0


@pytest.mark.slow
def test_report_and_replay_begin_with_warnings(tmp_path: Path) -> None:
    result = run(Experiment.load(PLANAR_2R, WEAK), tmp_path, coupling="direct")
    line = result.summary["warnings"][0]
    page = report_page(result)
    assert page.index(line) < page.index("Summary")
    assert notes(result)[0] == f"warning: {line}"
    assert line in result._repr_html_()


@pytest.mark.parametrize("through", ["direct", "native"])
def test_diverging_run_ends_with_an_error(through: str, tmp_path: Path) -> None:
    settings = {"controller.kp": 1e9, "controller.kd": 1e9} | {
        f"muscles.cable_{k}.f_max": 1e15 for k in range(1, 5)
    }
    experiment = Experiment.load(PLANAR_2R, settings)
    with pytest.raises(RunError, match="diverged") as caught:
        run(experiment, tmp_path, **RUN_MODES[through])  # type: ignore[arg-type]
    result = caught.value.result
    assert not result.complete
    assert result.rows[-1, 0] < experiment.run.duration


@pytest.mark.parametrize(
    ("column", "value", "words"),
    [
        ("qd.elbow", 1.1e3, "joint elbow moves 1.1 rad"),
        ("qd.elbow", np.nan, "qd.elbow is not finite at t = 0.03 s"),
        ("f.biceps", 1.1e9, "muscle biceps is 1.1e"),
        ("tension.biceps", 1.1e9, "muscle biceps is 1.1e"),
    ],
)
def test_motion_or_force_above_the_limit_is_divergence(
    column: str, value: float, words: str
) -> None:
    names, row = ("time", "q.elbow", column), np.array([0.03, 1e12, value])
    assert not abs(value) <= column_limits(names, 1e-3)[2]
    assert words in str(row_error(names, row, 1e-3))
    row[2] = 0.9 * (1e3 if column == "qd.elbow" else 1e9)  # a position may be anything
    assert row_error(names, row, 1e-3) is None
    assert (np.abs(row) <= column_limits(names, 1e-3)).all()


def tracking_summary(error: float, moves: float) -> dict[str, object]:
    row = {"rms": error, "max": error, "moves": moves, "unit": "rad"}
    return {"tracking": {"per_signal": {"q.elbow": row}}}


def test_large_tracking_errors_are_reported() -> None:
    assert problems(tracking_summary(0.015, 0.1)) == []
    assert problems(tracking_summary(0.009, 0.0)) == []
    assert "tracking error up to 0.06 rad at q.elbow" in problems(tracking_summary(0.06, 0.1))[0]
    assert problems({}) == []


def test_not_converged_ticks_are_not_reported_as_infeasible() -> None:
    summary = {"infeasible_ticks": 0, "not_converged_ticks": 2, "ticks": 10}
    assert problems(summary) == [
        "2 of 10 ticks not converged: feasible forces may exist, but none were found"
    ]


@pytest.mark.parametrize("through", ["direct", "native"])
def test_masses_scaled_to_zero_are_rejected(through: str, tmp_path: Path) -> None:
    experiment = Experiment.load(PLANAR_2R, {"plant.mass_scale": 1e-100})
    with pytest.raises(
        InputError,
        match=r"plant\.mass_scale: link 'link_2': no inertia about.*; give the link a mass",
    ):
        run(experiment, tmp_path, **RUN_MODES[through])
