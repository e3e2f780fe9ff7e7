"""Tests of both examples with muscle laws."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import read_robot
from addin_sdfusion.robot.checks.check import check
from cardsflow_fmu import Experiment, run


@pytest.mark.parametrize("example", ["hill_arm", "pneumatic_elbow"])
def test_robot_has_no_findings(example: str) -> None:
    assert [f.message for f in check(read_robot(EXAMPLES / example / "robot")) if f.is_error] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("example", "duration", "label"),
    [("hill_arm", 0.6, b"excitation"), ("pneumatic_elbow", 0.5, b"pressure [Pa]")],
)
def test_run_draws_a_figure(example: str, duration: float, label: bytes, tmp_path: Path) -> None:
    experiment = Experiment.load(
        EXAMPLES / example, {"run.duration": duration, "run.figures": True}
    )
    run(experiment, tmp_path)
    assert (tmp_path / "tracking.png").stat().st_size > 1000
    assert label in (tmp_path / "tracking.svg").read_bytes()
