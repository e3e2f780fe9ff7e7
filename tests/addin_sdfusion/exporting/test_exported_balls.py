"""A ball joint with limits is one joint in MJCF and OpenSim, without massless links."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from fake_fusion import designs
from support.designs.exported import export

from addin_sdfusion.robot import Robot, read_robot

BOUNDS = ((-1.0, 1.2), (-0.9, 0.8), (-0.7, 0.6))


@pytest.fixture
def exported(fusion: Any, tmp_path: Path) -> tuple[Robot, Path]:
    """Return the robot of a torso with a limited ball joint, and the folder of its export."""
    settings = {"mjcf": True, "visual": False, "collision": "none"}
    return export(designs.shoulder_with_gimbal(), tmp_path, **settings).robot, tmp_path


def limits(robot: Robot) -> list[Any]:
    return [pytest.approx((c.lower, c.upper), abs=1e-15) for c in robot.coordinates]


def test_limits_of_a_ball_joint_are_exported(exported: tuple[Robot, Path]) -> None:
    robot, folder = exported
    assert [(c.lower, c.upper) for c in robot.coordinates] == limits(robot) == list(BOUNDS)
    for file in ("shoulder.osim", "mjcf/shoulder.xml"):
        other = read_robot(folder / file)
        assert [(c.lower, c.upper) for c in other.coordinates] == limits(robot)
        assert len(other.links) == len(robot.links) == 2


def test_formats_with_three_axes_have_no_massless_links(exported: tuple[Robot, Path]) -> None:
    _, folder = exported
    mjcf = ElementTree.parse(folder / "mjcf/shoulder.xml")
    (body,) = mjcf.iterfind(".//body[@name='arm']")
    assert [joint.get("limited") for joint in body.findall("joint")] == ["true"] * 3
    assert len(list(mjcf.iter("body"))) == 2
    osim = ElementTree.parse(folder / "shoulder.osim")
    assert len(list(osim.iter("Body"))) == 2
    (joint,) = osim.iter("CustomJoint")
    assert [c.findtext("clamped") for c in joint.iter("Coordinate")] == ["true"] * 3
