"""Mass on a line with a motor, whose optimal motions have closed forms."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cardsflow_fmu.simulation.optimal.optimise import OptimisedMotion, load_for_motion, optimise

URDF = """<robot name="slider"><link name="base"/>
<link name="mass"><inertial><mass value="2"/>
<inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="mass"/><axis xyz="1 0 0"/>
<limit effort="500" velocity="90" lower="-90" upper="90"/></joint></robot>"""

TOML = """
robot.path = "slider.urdf"
robot.joints.x = { motor = true, effort = 500.0 }
start.q = 0.0
controller = { kp = 100.0, kd = 20.0 }

[motion]
duration = 0.8
intervals = 20
goals = [{ q = 1.0 }]
"""

MASS = 2.0


def slider_file(folder: Path) -> Path:
    """Write an experiment with the robot into a folder."""
    (folder / "slider.urdf").write_text(URDF)
    (folder / "experiment.toml").write_text(TOML)
    return folder / "experiment.toml"


def slide(folder: Path, settings: Mapping[str, Any]) -> OptimisedMotion:
    """Return an optimal motion of the mass."""
    return optimise(load_for_motion(slider_file(folder), settings))


def responses(N: int, T: float, nodes: list[int]) -> NDArray[np.float64]:
    """Return positions, then velocities, at nodes by forces in N intervals and v0.

    Returns:
        Shape (2 k, N + 1); the last column belongs to the velocity at the start.
    """
    h = T / N
    left = np.maximum(np.array(nodes)[:, None] - np.arange(N), 0)
    speeds = (left > 0) * h / MASS
    positions = (left > 0) * h * h * (left - 0.5) / MASS
    of_start = np.array(nodes) * h, np.ones(len(nodes))
    return np.column_stack([np.vstack([positions, speeds]), np.concatenate(of_start)])
