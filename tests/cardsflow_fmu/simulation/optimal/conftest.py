"""The planar arm in a folder of its own, with an optimal motion."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from support.robots.robots import PLANAR_2R

MOTION = """
[robot]
path = "robot/planar_2r_bodies.xml"

[start]
q = [-0.5, 0.5]

[motion]
duration = 0.6
intervals = 20
goals = [{ q = [0.6, -0.4] }]

[reference]
type = "optimised"

[controller]
kp = 2000.0
kd = 90.0

[run]
coupling = "direct"
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return the experiment of the arm with its motion."""
    shutil.copytree(PLANAR_2R / "robot", tmp_path / "robot")
    (tmp_path / "experiment.toml").write_text(MOTION)
    return tmp_path / "experiment.toml"
