"""Cable-driven platform with swivelling pulleys and winches."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import check, read_robot
from cardsflow_fmu import Experiment, run

ROBOT = EXAMPLES / "cable_robot"
DRIVES = {
    "muscles.*.model.kind": "winch_position",
    "muscles.*.model.position_gain": 300.0,
    "muscles.*.model.velocity_gain": 4.0,
}


def test_robot_has_no_findings() -> None:
    assert check(read_robot(ROBOT / "robot")) == []


@pytest.mark.slow
@pytest.mark.native
@pytest.mark.parametrize("drives", [{}, DRIVES], ids=["torque", "position"])
def test_winches_follow_the_commanded_tensions(drives: dict[str, Any], tmp_path: Path) -> None:
    found = run(Experiment.load(ROBOT, drives | {"run.duration": 1.0}), tmp_path, coupling="direct")
    assert found.summary["infeasible_ticks"] == 0
    assert found.summary["tracking"]["max"] < 0.006
    names = [name[2:] for name in found.names if name.startswith("f.")]
    asked, pulled = (found.columns([f"{what}.{n}" for n in names]) for what in ("f", "tension"))
    assert np.abs(pulled - asked).max() < 3.0  # dry friction causes an error of 1.25 N
