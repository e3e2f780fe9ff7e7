"""Both examples of muscles with laws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import read_robot
from addin_sdfusion.robot.checks.check import check
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.simulation.run import simulate


@pytest.mark.parametrize("example", ["hill_arm", "pneumatic_elbow"])
def test_the_robot_is_sound(example: str) -> None:
    assert [f.message for f in check(read_robot(EXAMPLES / example / "robot")) if f.is_error] == []


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_figures")
@pytest.mark.parametrize(
    ("example", "duration", "label"),
    [("hill_arm", 0.6, b"excitation"), ("pneumatic_elbow", 0.5, b"pressure [Pa]")],
)
def test_fmus_give_equal_columns_and_a_figure(
    example: str, duration: float, label: bytes, tmp_path: Path
) -> None:
    experiment = Experiment.load(EXAMPLES / example, {"run.duration": duration})
    fmu, direct = (
        run(experiment, tmp_path, compute="python"),
        simulate(experiment, compute="python", coupling="direct"),
    )
    np.testing.assert_allclose(fmu.rows, direct.rows, rtol=1e-12, atol=1e-12)
    assert (tmp_path / "tracking.png").stat().st_size > 1000
    assert label in (tmp_path / "tracking.svg").read_bytes()
