"""The planar arm of the paper, simulated from its files through FMUs to results."""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
from support.cases import sample_cases
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment, Result, build, run
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.simulation.run import RunError, simulate


@pytest.fixture(scope="module")
def at_1_khz() -> Result:
    return simulate(Experiment.load(PLANAR_2R))


def test_run_at_1_khz_tracks_like_the_paper(at_1_khz: Result) -> None:
    summary = at_1_khz.summary
    assert summary["status"] == "complete"
    assert summary["ticks"] == 8000
    assert summary["infeasible_ticks"] == 0
    assert summary["tracking"]["rms"] < 1e-5
    assert summary["forces"]["min"] >= 10.0
    assert summary["forces"]["max"] < 41.5
    assert at_1_khz.rows.shape[0] == 8001
    assert at_1_khz["time"][-1] == 8.0


def test_summary_matches_the_columns(at_1_khz: Result) -> None:
    q, q_d = (at_1_khz.columns([f"{p}.joint_{k}" for k in (1, 2)]) for p in ("q", "q_d"))
    rms = np.sqrt(np.mean(np.sum((q - q_d) ** 2, axis=1)))
    assert at_1_khz.summary["tracking"]["rms"] == pytest.approx(rms, rel=1e-12)
    forces = at_1_khz.columns([f"f.cable_{k}" for k in (1, 2, 3, 4)])
    assert at_1_khz.summary["forces"]["max"] == forces.max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "cable_set"),
    sample_cases(
        [("r2head", "basic"), ("r2oct", "basic_4_cables_2018_10"), ("r2jul", "basic_2018_07")]
    ),
)
def test_control_at_100_hz_matches_the_closed_loop_of_caspr(
    shared: Path, file: str, cable_set: str
) -> None:
    """Forces agree within 1 %, and the tracking errors are of the same size."""
    caspr = json.loads((shared / f"reference/caspr/closed_loop_CTC_2R__{file}.json").read_text())
    settings = {"controller.period": 0.01, "robot.cable_set": cable_set}
    result = simulate(Experiment.load(PLANAR_2R, settings))
    rows = np.rint(np.array(caspr["t"]) / 1e-3).astype(int)
    forces = result.columns([f"f.cable_{k}" for k in (1, 2, 3, 4)])[rows].T
    np.testing.assert_allclose(forces, caspr["f"], rtol=0.01)
    q = result.columns(["q.joint_1", "q.joint_2"])[rows].T
    np.testing.assert_allclose(q, caspr["q"], rtol=0, atol=1e-3)
    assert result.summary["tracking"]["max"] == pytest.approx(0.003, abs=0.001)
    assert result.summary["infeasible_ticks"] == 0


@pytest.mark.slow
def test_reference_fmu_starts_at_the_start_time_of_the_host(tmp_path: Path) -> None:
    file = build(Experiment.load(PLANAR_2R), tmp_path / "made/for/it")["reference"]
    result = simulate_fmu(str(file), start_time=1.0, stop_time=1.01, output_interval=0.001)
    s = 0.25
    expected = -0.5 + 10 * s**3 - 15 * s**4 + 6 * s**5
    assert result["q_d.joint_1"][0] == pytest.approx(expected, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["plant", "controller", "reference"])
def test_each_fmu_runs_in_fmpy_without_options(name: str, tmp_path: Path) -> None:
    file = build(Experiment.load(PLANAR_2R), tmp_path)[name]
    assert len(simulate_fmu(str(file))) > 100


@pytest.mark.slow
def test_failed_run_leaves_no_files_of_the_previous_run(tmp_path: Path) -> None:
    run(Experiment.load(PLANAR_2R, {"run.duration": 0.05}), tmp_path)
    run(Experiment.load(PLANAR_2R, {"run.duration": 0.05}), tmp_path, coupling="direct")
    assert not list(tmp_path.glob("*.fmu"))


@pytest.mark.slow
def test_plant_converges_with_first_order() -> None:
    """Substeps evaluate L and f again, so that the plant converges with first order."""
    rows = []
    for step in (1e-3, 5e-4, 2.5e-4):
        settings = {"run.duration": 1.0, "plant.step": step}
        rows.append(simulate(Experiment.load(PLANAR_2R, settings), coupling="direct")["q.joint_1"])
    coarse, fine = np.abs(rows[0] - rows[1]).max(), np.abs(rows[1] - rows[2]).max()
    assert 0 < fine < 0.8 * coarse


def test_run_writes_readable_results(tmp_path: Path) -> None:
    result = run(
        Experiment.load(PLANAR_2R, {"run.duration": 0.1, "run.figures": True}), tmp_path / "out"
    )
    with (tmp_path / "out/results.csv").open() as file:
        names, *rows = csv.reader(file)
    assert names[0] == "time"
    np.testing.assert_array_equal(np.array(rows, float), result.rows)  # exact floats
    units = json.loads((tmp_path / "out/results.units.json").read_text())
    assert list(units) == names
    assert units["q.joint_1"] == "rad"
    assert units["f.cable_1"] == "N"
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary == result.summary
    assert set(summary["files"].values()) == {p.name for p in (tmp_path / "out").iterdir()}
    assert (tmp_path / "out/tracking.png").read_bytes().startswith(b"\x89PNG")
    assert b"force command" in (tmp_path / "out/tracking.svg").read_bytes()


@pytest.mark.slow
def test_second_run_only_replaces_files_of_the_first_run(tmp_path: Path) -> None:
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 0.05})
    run(experiment, tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    first = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    run(experiment, tmp_path)
    second = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    timed = ("summary.json", "solve_times.csv")
    assert {k: v for k, v in first.items() if k not in timed} == {
        k: v for k, v in second.items() if k not in timed
    }


def test_fmus_are_valid_and_self_contained(tmp_path: Path) -> None:
    for file in build(Experiment.load(PLANAR_2R), tmp_path).values():
        assert validate_fmu(str(file)) == []


@pytest.mark.slow
def test_diverging_run_ends_with_a_message_and_keeps_results(tmp_path: Path) -> None:
    """Very high gains destabilise the sampled loop, since the force limits are removed.

    The test uses DART, since joint limits in the core resist any force.
    """
    settings = {
        "plant.engine": "dart",
        "controller.kp": 1e8,
        "controller.kd": 0.0,
        "start.q": [-0.4, 0.5],
        **{f"muscles.cable_{k}.f_max": 1e12 for k in (1, 2, 3, 4)},
    }
    with pytest.raises(RunError, match=r"^the run has diverged: at t = 0\.001 s joint") as caught:
        run(Experiment.load(PLANAR_2R, settings), tmp_path)
    assert "Traceback" not in str(caught.value)
    assert not caught.value.result.complete
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["status"] == "incomplete"
    assert "diverged" in summary["error"]
    assert len((tmp_path / "results.csv").read_text().splitlines()) == 3, "the last row shows it"


def cardsflow(*words: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "cardsflow_fmu.cli", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, check=False)


def test_command_prints_a_short_summary(tmp_path: Path) -> None:
    done = cardsflow("run", PLANAR_2R, "--set", "run.duration=0.2", "-o", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "\r" not in done.stderr  # no progress bar, since the output is not a terminal
    for words in ("RMS", "max", "q.joint_1", "limits 10 to 100", "0 of 200 ticks", "real time"):
        assert words in done.stdout
    assert f"{tmp_path / 'out'}: " in done.stdout
    assert "results.csv" in done.stdout
    assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f]", done.stdout)


@pytest.mark.slow
def test_closed_output_pipe_is_not_an_error(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "cardsflow_fmu.cli", "info", str(PLANAR_2R / "robot")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0


BAD_COMMANDS = {
    "missing experiment": (["run", "{tmp}/none"], "none"),
    "unwritable output": (["run", PLANAR_2R, "-o", "{tmp}/file/out"], "cannot be written"),
    "unknown key": (["run", PLANAR_2R, "--set", "controller.kq=1"], "did you mean 'kp'"),
    "endless number": (["run", PLANAR_2R, "--set", "controller.kp=1" + "0" * 400], "64 bits"),
    "unreadable number": (["run", PLANAR_2R, "--set", "controller.kp=" + "1" * 5000], "be read"),
    "unreadable list": (["run", PLANAR_2R, "--set", "controller.kp=" + "[" * 3000], "be read"),
    "no regular file": (["run", "/dev/zero"], "is not a regular file"),
    "wrong wire": (
        ["run", PLANAR_2R, "--set", 'wiring.controller={"q.joint_1"="plant.q.jint_1"}'],
        "did you mean 'plant.q.joint_1'",
    ),
    "no value": (["run", PLANAR_2R, "--set", "controller.kp"], "KEY=VALUE"),
    "missing robot": (["check", "{tmp}/none.sdf"], "none.sdf"),
    "not a robot": (["check", "{tmp}/file"], "is not a robot"),
}


@pytest.mark.parametrize("case", BAD_COMMANDS)
def test_bad_input_is_a_one_line_error_with_exit_code_2(
    tmp_path: Path, case: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    words, message = BAD_COMMANDS[case]
    monkeypatch.chdir(tmp_path)
    assert main([str(word).replace("{tmp}", str(tmp_path)) for word in words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(rf"cardsflow: .*{re.escape(message)}.*\n", err)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


@pytest.mark.slow
def test_check_warns_about_zero_inertia(tmp_path: Path) -> None:
    done = cardsflow("check", PLANAR_2R / "robot")
    assert done.returncode == 0
    assert "planar_2r_bodies.xml:" in done.stdout
    assert "zero-inertia-about-axis" in done.stdout
    assert "0 errors, 2 warnings" in done.stdout
    findings = json.loads(cardsflow("check", PLANAR_2R / "robot", "--json").stdout)
    assert {f["name"] for f in findings} == {"link_1", "link_2"}


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize(
    "start", sample_cases([[0.0, 0.5], [-1.0, 0.5], [-0.5, 1.0], [-0.5, 0.0]], 2)
)
@pytest.mark.parametrize("period", [0.005, 0.01])
def test_loop_recovers_from_a_start_error_of_half_a_radian(
    start: list[float], period: float
) -> None:
    """Forces saturate temporarily after a start error, and all these ticks are reported."""
    experiment = Experiment.load(PLANAR_2R, {"start.q": start, "controller.period": period})
    result = simulate(experiment, coupling="direct")
    summary = result.summary
    assert summary["tracking"]["rms"] < 0.05
    assert summary["infeasible_ticks"] <= 20
    assert summary["infeasible_ticks"] * period <= 0.1
    ticks = np.flatnonzero(result["infeasible"][:: round(period / 1e-3)])
    assert summary["infeasible_ticks"] == len(ticks)
    if len(ticks):
        assert summary["slack"]["first_at_s"] == pytest.approx(ticks[0] * period)
        assert max(part["max"] for part in summary["slack"]["per_signal"].values()) > 1.0
    assert np.abs(result.columns(["q.joint_1", "q.joint_2"])[-1] - [-0.5, 0.5]).max() < 1e-3


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("type_", "kp", "kd", "largest"),
    [
        ("force_position", 2000.0, 90.0, 1e-3),
        ("lyapunov", [480.0, 50.0], [21.0, 2.2], 1e-3),
        ("torque_position", [480.0, 50.0], [21.0, 2.2], 0.03),
    ],
)
def test_other_joint_space_controllers_run_as_fmus(
    type_: str, kp: object, kd: object, largest: float, tmp_path: Path
) -> None:
    settings = {"controller.type": type_, "controller.kp": kp, "controller.kd": kd}
    result = simulate(Experiment.load(PLANAR_2R, settings), coupling="direct")
    assert result.summary["tracking"]["max"] < largest
    experiment = Experiment.load(PLANAR_2R, settings | {"run.duration": 0.1})
    file = build(experiment, tmp_path)["controller"]
    assert validate_fmu(str(file)) == []
    kp_port = next(v for v in read_model_description(file).modelVariables if v.name == "kp.joint_1")
    assert kp_port.unit == ("1/s2" if type_ == "force_position" else "N.m/rad")
