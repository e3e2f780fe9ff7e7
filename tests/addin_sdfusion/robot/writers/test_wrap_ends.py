"""Via points inside wrap surfaces: the difference to other programs is reported correctly."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from support.robots.one_link import cable, one_link

from addin_sdfusion.robot import WORLD, Pose, Robot, Wrap, WrapSurface
from addin_sdfusion.robot.formats.mjcf.capabilities import mjcf_losses
from addin_sdfusion.robot.formats.mjcf.write import write_mjcf
from addin_sdfusion.robot.formats.opensim.capabilities import osim_losses
from sim_dart import CoreDynamics

CODE = "via-point-inside-wrap"


def _robot(seed: int, shape: str) -> Robot:
    """Return a muscle from the world to a point on a rotating link, which may enter a surface."""
    rng = np.random.default_rng(seed)
    pose = Pose(tuple(rng.uniform(-0.05, 0.05, 3)), tuple(rng.uniform(-0.3, 0.3, 3)))
    surface = WrapSurface("round", WORLD, shape, 0.3, pose)  # type: ignore[arg-type]
    end = (float(rng.uniform(0.15, 0.35)), 0.05, float(rng.uniform(-0.05, 0.05)))
    start = (float(rng.uniform(-1.0, -0.4)), float(rng.uniform(-0.1, 0.1)), 0.02)
    muscle = cable(start, end, wraps=(Wrap("round", 0),))
    limits = {"lower": -1.0, "upper": 1.0, "initial": float(rng.uniform(-1.0, 1.0))}
    return one_link(muscles=[muscle], surfaces=[surface], **limits)


def _apart(robot: Robot, folder: Path) -> Callable[[float], float]:
    """Return the length of our path minus the length of MuJoCo's path, in [m], over q."""
    (file,) = write_mjcf(robot, folder, "robot")
    model = mujoco.MjModel.from_xml_path(str(file))
    data, dynamics = mujoco.MjData(model), CoreDynamics(robot)

    def apart(q: float) -> float:
        data.qpos[0] = q
        mujoco.mj_forward(model, data)
        return float(dynamics.muscle_lengths([q])[0] - data.ten_length[0])

    return apart


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_reported_difference_to_a_straight_path_agrees_with_mujoco(
    shape: str, tmp_path: Path
) -> None:
    reported = []
    for seed in range(30):
        robot = _robot(seed, shape)
        found = [finding for finding in mjcf_losses(robot) if finding.code == CODE]
        reported.append(bool(found))
        apart = _apart(robot, tmp_path)
        largest = max(map(apart, np.linspace(-1.0, 1.0, 41)))
        assert bool(found) == (largest > 1e-4) or largest < 1e-3
        assert [f.message.replace("OpenSim", "MuJoCo") for f in osim_losses(robot)
                if f.code == CODE] == [finding.message for finding in found]  # fmt: skip
        if not found:
            continue
        numbers = re.findall(r"([0-9.e+-]+) m (?:apart )?at", found[0].message)
        initial = robot.coordinates[0].initial
        assert float(numbers[0]) == pytest.approx(apart(initial), rel=0.06)
        if len(numbers) > 1:
            q = float(found[0].message.split("q = ")[1].split()[0])
            assert float(numbers[1]) == pytest.approx(apart(q), rel=0.1)
            assert float(numbers[1]) == pytest.approx(largest, rel=0.2)
    assert any(reported)
    assert not all(reported)


def test_longer_side_and_tapered_end_are_included() -> None:
    """Both ends at 0.2 m from the axis of a cylinder of radius 0.3 m: it shrinks to 0.2 m."""
    end, side = (0.0, 0.2, 0.0), Wrap("round", 0, 1)
    surface = WrapSurface("round", WORLD, "cylinder", 0.3)
    robot = one_link(muscles=[cable((-0.2, 0.0, 0.0), end, wraps=(side,))], surfaces=[surface])
    (found,) = [finding for finding in osim_losses(robot) if finding.code == CODE]
    longer = 0.2 * 1.5 * math.pi - 0.2 * math.sqrt(2.0)
    assert f"{longer:.2g} m apart at the initial" in found.message
    ours = CoreDynamics(robot).muscle_lengths([0.0])[0]
    assert ours == pytest.approx(0.2 * 1.5 * math.pi)
    beyond = replace(surface, pose=Pose((0.0, 0.0, 1.0)), length=1.0)
    robot = replace(robot, wrap_surfaces=(beyond,))
    assert CODE not in {finding.code for finding in osim_losses(robot)}


def test_end_outside_has_no_finding() -> None:
    surface = WrapSurface("round", WORLD, "sphere", 0.1)
    outside = cable((-1.0, 0.0, 0.0), (0.5, 0.0, 0.0), wraps=(Wrap("round", 0),))
    robot = one_link(muscles=[outside], surfaces=[surface])
    assert CODE not in {finding.code for finding in osim_losses(robot)}
