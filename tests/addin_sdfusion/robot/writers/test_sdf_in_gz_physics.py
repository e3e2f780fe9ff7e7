"""gz-physics of Gazebo simulates written SDF files like the C core."""

from __future__ import annotations

import math
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.random_robots import random_robot, random_tree
from support.robots.robots import EXAMPLES, with_coordinates

from addin_sdfusion.robot import Robot, read_robot, write_sdf
from addin_sdfusion.robot.formats.sdf.write_joints import sdf_joints
from sim_dart import Plant

pytestmark = pytest.mark.interop

PACKAGES = ("ignition-physics5-sdf", "ignition-plugin1-loader", "sdformat12")
SOURCE = Path(__file__).parents[3] / "support/oracles/gz_swing.cpp"
ENGINES = Path("/usr/lib").glob("*/ign-physics-5/engine-plugins/*dartsim-plugin.so.5")
STEPS = 1000


@pytest.fixture(scope="module")
def swing(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Return the command that simulates a model."""
    engine = next(ENGINES, None)
    flags = subprocess.run(
        [shutil.which("pkg-config") or "false", "--cflags", "--libs", *PACKAGES],
        capture_output=True,
        text=True,
        check=False,
    )
    if engine is None or flags.returncode or shutil.which("g++") is None:
        pytest.skip("needs libignition-physics-sdf-dev, libignition-physics5-dartsim-plugin5")
    program = tmp_path_factory.mktemp("gz") / "swing"
    subprocess.run(["g++", SOURCE, "-o", program, *flags.stdout.split()], check=True)
    return [str(program), str(engine)]


def robots() -> list[Robot]:
    """Return the arms of the examples, and random trees."""
    arms = [
        read_robot(EXAMPLES / name / "robot")
        for name in ("planar_2r", "hill_arm", "roboy_left_arm")
    ]
    return [*arms, *map(random_tree, range(1, 6)), *map(random_robot, range(3))]


@pytest.mark.parametrize("robot", robots(), ids=lambda robot: robot.name)
def test_free_swing_of_one_second_agrees(robot: Robot, swing: list[str], tmp_path: Path) -> None:
    """Without muscles and limits, from random positions and velocities."""
    robot = replace(robot, cable_sets=(), cable_set="")
    robot = with_coordinates(robot, lower=-math.inf, upper=math.inf)
    write_sdf(robot, tmp_path, plugin=False)
    n, rng = len(robot.coordinates), np.random.default_rng(0)
    q, qd = rng.uniform(-0.3, 0.3, n), rng.uniform(-0.2, 0.2, n)
    place = {c.name: k for k, c in enumerate(robot.coordinates)}
    parts = [part for joint in sdf_joints(robot).values() for part in joint]
    moved = [
        (part.name, i, place[c.name]) for part in parts for i, c in enumerate(part.coordinates)
    ]
    lines = "\n".join(f"{name} {i} {float(q[k])!r} {float(qd[k])!r}" for name, i, k in moved)
    assert robot.gravity[:2] == (0.0, 0.0)
    words = [*swing, str(tmp_path / "model.sdf"), repr(robot.gravity[2]), str(STEPS)]
    done = subprocess.run(words, input=lines, capture_output=True, text=True, check=True)
    theirs = np.empty(n)
    theirs[[k for *_, k in moved]] = [float(line) for line in done.stdout.split()]
    plant = Plant(robot, 1e-3)
    plant.reset(q, qd)
    for _ in range(STEPS):
        plant.step(np.zeros(0))
    assert np.abs(plant.q - q).max() > 0.1
    np.testing.assert_allclose(theirs, plant.q, rtol=0.0, atol=1e-8)
