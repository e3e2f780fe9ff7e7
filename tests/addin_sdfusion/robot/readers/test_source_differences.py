"""Findings where results differ from those of OpenSim and MuJoCo."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.robots.one_link import cable, one_link

from addin_sdfusion.robot import Motion, Robot
from addin_sdfusion.robot.formats.opensim.write import write_osim
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.model.function import linear
from addin_sdfusion.robot.model.muscle import PointMotion

AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
INSIDE = """<mujoco model="m"><worldbody>
  <site name="a" pos="-1 0 0.1"/>
  <body name="arm"><joint name="q" axis="0 1 0"/>
    <geom type="sphere" size="0.1" mass="1"/>
    <geom name="hole" type="sphere" size="0.3"/>
    <site name="side" pos="0 0 {height}"/><site name="b" pos="1 0 0.1"/>
  </body></worldbody>
  <tendon><spatial name="t"><site site="a"/><geom geom="hole" sidesite="side"/><site site="b"/>
  </spatial></tendon>
  <actuator><motor name="t" tendon="t"/></actuator></mujoco>"""


def codes(path: Path) -> set[str]:
    return {finding.code for finding in read(path).findings}


@pytest.mark.parametrize(("height", "is_inside"), [(0.2, True), (0.4, False)])
def test_inside_wraps_of_mujoco_are_reported(
    height: float, is_inside: bool, tmp_path: Path
) -> None:
    file = tmp_path / "m.xml"
    file.write_text(INSIDE.format(height=height), "utf-8")
    assert ("inside-wraps" in codes(file)) == is_inside


def test_moment_arms_of_moving_points_in_opensim_are_reported(tmp_path: Path) -> None:
    muscle = cable((0.0, 0.0, 1.0), (0.1, 0.0, 0.0))
    move = PointMotion((0.0, 0.0, 1.0), "q", linear(0.1), -0.5, 0.5)
    moving = replace(muscle.via_points[1], moves=(move,))
    moved = replace(muscle, via_points=(muscle.via_points[0], moving))
    reported = {
        name: read_again([m], tmp_path / name) for name, m in (("fixed", muscle), ("moved", moved))
    }
    assert "points-beyond-their-range" not in reported["fixed"]
    assert "points-beyond-their-range" in reported["moved"]


def read_again(muscles: list, folder: Path) -> set[str]:
    write_osim(one_link(muscles=muscles, lower=-0.5, upper=0.5), folder)
    return codes(folder)


@pytest.mark.parametrize("count", [2, 3])
def test_missing_term_of_opensim_is_reported_when_its_models_are_read(
    count: int, tmp_path: Path
) -> None:
    motions = tuple(
        Motion("rotation", axis, 0, linear(1.0 + k)) for k, axis in enumerate(AXES[:count])
    )
    robot: Robot = one_link(motions=motions)
    write_osim(robot, tmp_path)
    assert ("coriolis-in-opensim" in codes(tmp_path)) == (count == 3)
