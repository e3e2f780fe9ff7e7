"""Full turns around a spindle, specified by the robot or counted over calls."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from support.robots.wrapped import carriage

from addin_sdfusion.robot import WORLD, Muscle, Pose, Robot, ViaPoint, Wrap, WrapSurface
from sim_dart import MusclePaths

pytestmark = pytest.mark.native

R = 0.1
LINK = "link_2"


def spindle(side: int = -1, turns: int = 0, second: bool = False) -> Robot:
    """Return a cable to a point on the rim of a spindle, which the third coordinate rotates."""
    ends = (ViaPoint(WORLD, (1.0, -R, 0.0)), ViaPoint(LINK, (0.0, -R, 0.0)))
    surfaces = [WrapSurface("spindle", LINK, "cylinder", R)]
    wraps = [Wrap("spindle", 0, side, turns)]  # type: ignore[arg-type]
    if second:
        surfaces.append(WrapSurface("aside", WORLD, "cylinder", R))
        surfaces[1] = replace(surfaces[1], pose=Pose((0.5, -0.15, 0.0)))
        wraps.insert(0, Wrap("aside", 0, -1))
    return carriage([Muscle("m", ends, wraps=tuple(wraps))], surfaces, turning=True)


@pytest.mark.parametrize("second", [False, True], ids=["alone", "after another"])
def test_counted_turns_wind_and_unwind_the_cable(second: bool) -> None:
    """Check five turns in both directions. Each radian changes the length by R."""
    paths = MusclePaths(spindle(second=second), count_turns=True)
    start = float(paths.evaluate([0.0, 0.0, -0.5]).lengths[0])
    for angle in [*np.linspace(-0.5, -31.0, 60), *np.linspace(-31.0, -0.5, 60)]:
        (length,), L = paths.evaluate([0.0, 0.0, angle])
        assert length == pytest.approx(start + R * (-0.5 - angle), abs=1e-12)
        assert L[0, 2] == pytest.approx(-R, abs=1e-12)
    assert paths.evaluate([0.0, 0.0, -0.5]).lengths[0] == pytest.approx(start, abs=1e-12)


def test_unwinding_continues_in_the_opposite_direction() -> None:
    """The length is continuous across the straight cable."""
    paths = MusclePaths(spindle(), count_turns=True)
    angles = np.linspace(-1.0, 12.0, 2001)
    lengths = np.array([paths.evaluate([0.0, 0.0, a]).lengths[0] for a in angles])
    assert abs(np.diff(lengths)).max() < 1.2 * R * (angles[1] - angles[0])
    assert lengths[-1] - lengths[-2] == pytest.approx(R * (angles[1] - angles[0]), abs=1e-12)


def test_without_counting_the_same_pose_has_the_same_length() -> None:
    paths = MusclePaths(spindle())
    first = float(paths.evaluate([0.0, 0.0, -1.0]).lengths[0])
    paths.evaluate([0.0, 0.0, -4.0])
    turned = float(paths.evaluate([0.0, 0.0, -1.0 - 2 * math.pi]).lengths[0])
    assert turned == pytest.approx(first, abs=1e-12)


def test_counting_starts_at_the_specified_turns() -> None:
    whole = 2 * math.pi * R
    lengths = [
        MusclePaths(spindle(turns=turns), count_turns=counted).evaluate([0.0, 0.0, -1.0]).lengths[0]
        for turns in (0, 3)
        for counted in (False, True)
    ]
    assert lengths[0] == pytest.approx(lengths[1], abs=1e-13)
    assert lengths[2] == pytest.approx(lengths[0] + 3 * whole, abs=1e-13)
    assert lengths[3] == pytest.approx(lengths[2], abs=1e-13)


def test_counted_turns_can_be_saved_and_restored() -> None:
    paths = MusclePaths(spindle(), count_turns=True)
    for angle in np.linspace(0.0, -9.0, 10):
        paths.evaluate([0.0, 0.0, angle])
    saved, length = paths.turning.copy(), float(paths.evaluate([0.0, 0.0, -9.0]).lengths[0])
    for angle in np.linspace(-9.0, 0.0, 10):
        paths.evaluate([0.0, 0.0, angle])
    paths.turning[:] = saved
    assert paths.evaluate([0.0, 0.0, -9.0]).lengths[0] == length
    assert np.isnan(MusclePaths(spindle(), count_turns=True).turning).all()
