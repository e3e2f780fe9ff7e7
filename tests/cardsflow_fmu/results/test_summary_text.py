"""Summary of a run as text."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.simulation.run import simulate

NUMBER = r"[-+0-9.e]+"


def test_rms_is_at_most_the_maximum_error() -> None:
    """Each line is for one signal; the line of all signals states the norm."""
    settings = {"run.duration": 0.5}
    text = simulate(Experiment.load(EXAMPLES / "roboy_left_arm", settings)).describe(every=True)
    rows = re.findall(rf"RMS ({NUMBER}), max ({NUMBER})", text)
    assert len(rows) == 3
    assert all(float(rms) <= float(largest) for rms, largest in rows)
    assert "tracking    RMS tracking error " in text


def test_worst_five_signals_and_all_with_verbose() -> None:
    result = simulate(Experiment.load(EXAMPLES / "roboy_left_arm", {"run.duration": 0.1}))
    peaks = {n: m["max"] for n, m in result.summary["forces"]["per_muscle"].items()}
    worst = sorted(peaks, key=lambda name: -peaks[name])
    short, full = result.describe(), result.describe(every=True)
    assert re.findall(r"^  (f\.\w+)", short, re.M) == worst[:5]
    assert "  and 6 smaller; use --verbose" in short
    assert re.findall(r"^  (f\.\w+)", full, re.M) == list(peaks)


@pytest.mark.slow
def test_files_are_one_line_and_the_next_command_follows(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "my results"
    assert main(["run", str(PLANAR_2R), "--set", "run.duration=0.1", "-o", str(out)]) == 0
    *_, files, following = capsys.readouterr().out.splitlines()
    assert files.startswith(f"files       {out}: ")
    assert {"summary.json", "results.csv"} <= set(files.rpartition(": ")[2].split(", "))
    assert following == f"next        cardsflow view '{out}'"


@pytest.mark.parametrize("where", ["robot", "robot/model.sdf"])
def test_message_for_a_robot_suggests_init(where: str) -> None:
    path = EXAMPLES / "hill_arm" / where
    with pytest.raises(
        InputError, match=rf"is a robot; create an experiment: `cardsflow init {path} "
    ):
        run(Experiment.load(path))
