"""`cardsflow excite`: an experiment with a motion for a calibration."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.cases import LONG
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R

from cardsflow_fmu.utils.csv_table import read_csv

ROBOT = PLANAR_2R / "robot"
FREE = "muscles.*.offset, joints.*.damping"


@LONG
@pytest.mark.slow
def test_designed_motion_is_run_and_used_for_calibration(
    cardsflow: CommandLine, tmp_path: Path
) -> None:
    """The commands of the report are run. The robot is exact, so that no parameter changes."""
    there = tmp_path / "exciting"
    code, out, _ = cardsflow("excite", ROBOT, "--parameters", FREE, "--duration", "6", "-o", there)
    assert code == 0
    assert "6 numbers; a recording of the motion identifies 6 of them" in out
    assert f"cardsflow run {there} --hardware" in out
    names, rows = read_csv(there / "motion.csv")
    assert names == ("time", "q.joint_1", "q.joint_2")
    assert rows[-1, 0] == pytest.approx(6.0)
    np.testing.assert_allclose(rows[0, 1:], rows[-1, 1:], atol=1e-12)
    assert "choose a new folder" in cardsflow.error_line("excite", ROBOT, "-o", there)

    assert cardsflow("run", there, "--coupling", "direct")[0] == 0
    new = tmp_path / "calibrated"
    words = [there / "results", "--robot", ROBOT, "--parameters", FREE, "-o", new]
    assert cardsflow("calibrate", *words)[0] == 0
    for one in json.loads((new / "calibration.json").read_text())["parameters"]:
        assert one["identifiable"]
        assert abs(one["change"]) < max(4 * one["sd"], 1e-3 * one["prior_sd"])


@pytest.mark.slow
def test_no_file_is_written_if_the_design_fails(cardsflow: CommandLine, tmp_path: Path) -> None:
    there = tmp_path / "exciting"
    for words, message in (
        (("--duration", "1"), "--duration"),
        (("--speed", "0"), "--speed"),
        (("--parameters", "muscles.*.ofset"), "unknown parameter 'muscles.*.ofset'"),
    ):
        assert message in cardsflow.error_line("excite", ROBOT, *words, "-o", there)
        assert not there.exists()
    assert cardsflow.error_line("excite", tmp_path / "nowhere", "-o", there)
