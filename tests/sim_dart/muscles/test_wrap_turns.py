"""Full turns around a spindle that the robot specifies."""

from __future__ import annotations

import math

import pytest
from support.robots.wrapped import carriage

from addin_sdfusion.robot import WORLD, Muscle, Robot, ViaPoint, Wrap, WrapSurface
from sim_dart import MusclePaths

pytestmark = pytest.mark.native

R = 0.1
LINK = "link_2"


def spindle(turns: int = 0) -> Robot:
    """Return a cable to a point on the rim of a spindle, which the third coordinate rotates."""
    ends = (ViaPoint(WORLD, (1.0, -R, 0.0)), ViaPoint(LINK, (0.0, -R, 0.0)))
    wraps = (Wrap("spindle", 0, -1, turns),)
    surfaces = [WrapSurface("spindle", LINK, "cylinder", R)]
    return carriage([Muscle("m", ends, wraps=wraps)], surfaces, turning=True)


def test_the_same_pose_has_the_same_length() -> None:
    paths = MusclePaths(spindle())
    first = float(paths.evaluate([0.0, 0.0, -1.0]).lengths[0])
    paths.evaluate([0.0, 0.0, -4.0])
    turned = float(paths.evaluate([0.0, 0.0, -1.0 - 2 * math.pi]).lengths[0])
    assert turned == pytest.approx(first, abs=1e-12)


def test_specified_turns_add_their_length() -> None:
    free, wound = (
        MusclePaths(spindle(turns)).evaluate([0.0, 0.0, -1.0]).lengths[0] for turns in (0, 3)
    )
    assert wound == pytest.approx(free + 3 * 2 * math.pi * R, abs=1e-13)
