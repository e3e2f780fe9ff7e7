"""Parallel computation of wraps equals the computation of single wraps."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from support.cases import sample_cases
from support.robots.wrapped import FAR, carriage, single_wraps

from addin_sdfusion.robot import WORLD, Muscle, Robot, ViaPoint, Wrap, WrapSurface
from addin_sdfusion.robot.model.muscle import WrapShape
from sim_dart import MusclePaths
from sim_dart.core.library import Core

pytestmark = pytest.mark.native


def single_muscle_robots(robot: Robot) -> list[MusclePaths]:
    """Return one robot per muscle, since a single wrap is not computed in parallel."""
    return [MusclePaths(robot.with_muscles([muscle])) for muscle in robot.muscles]


@pytest.mark.cases(4)
@pytest.mark.parametrize("surface_link", [WORLD, "link_1", FAR])
@pytest.mark.parametrize("count", sample_cases([17, 2, 16, 50]))
def test_parallel_wraps_equal_single_wraps(surface_link: str, count: int) -> None:
    """Check all kinds, with surfaces fixed to one end, both ends or neither."""
    rng = np.random.default_rng(count)
    robot = single_wraps(rng, count, sides=(0, 1, -1), turns=(0, 0, 1), lengths=(0.2, math.inf))
    surfaces = tuple(replace(s, link=surface_link) for s in robot.wrap_surfaces)
    robot = replace(robot, wrap_surfaces=surfaces)
    together, alone = MusclePaths(robot), single_muscle_robots(robot)
    for q in rng.uniform(-0.3, 0.3, (40, 3)):
        lengths, L = together.evaluate(q)
        for k, paths in enumerate(alone):
            length, row = paths.evaluate(q)
            assert lengths[k] == pytest.approx(length[0], abs=1e-14)
            np.testing.assert_allclose(L[k], row[0], rtol=0, atol=1e-12)


def test_parallel_wraps_with_the_rule_of_mujoco_equal_single_wraps() -> None:
    """Check side points on all sides, inside, and none, and ends inside of the surface."""
    rng, muscles = np.random.default_rng(5), []
    robot = single_wraps(rng, 60)
    for k, muscle in enumerate(robot.muscles):
        centre = np.array(robot.wrap_surfaces[k].pose.position)
        side = ViaPoint(
            WORLD, tuple(map(float, centre + rng.normal(size=3) * rng.choice([0.05, 0.4])))
        )
        wrap = replace(muscle.wraps[0], rule="mujoco", side_point=side if k % 3 else None)
        muscles.append(replace(muscle, wraps=(wrap,)))
    robot = robot.with_muscles(muscles)
    together, alone, bent = MusclePaths(robot), single_muscle_robots(robot), 0
    for q in rng.uniform(-0.4, 0.4, (20, 3)):
        lengths, L = together.evaluate(q)
        for k, paths in enumerate(alone):
            length, row = paths.evaluate(q)
            a, b = (np.array(point.position) for point in muscles[k].via_points)
            bent += length[0] > np.linalg.norm(b + q - a) + 1e-9
            assert lengths[k] == pytest.approx(length[0], abs=1e-14)
            np.testing.assert_allclose(L[k], row[0], rtol=0, atol=1e-12)
    assert 300 < bent < 900


def fan(
    shape: WrapShape, side: Literal[0, 1, -1], angles: NDArray[np.float64], climb: float
) -> Robot:
    """Return muscles over surfaces of 0.1 m, with ends 0.3 m from the axis at several angles."""
    muscles, surfaces = [], []
    for k, angle in enumerate(angles):
        far = (0.3 * math.cos(angle), 0.3 * math.sin(angle), climb)
        ends = (ViaPoint(WORLD, (0.3, 0.0, 0.0)), ViaPoint(FAR, far))
        surfaces.append(WrapSurface(f"s{k}", WORLD, shape, 0.1))
        muscles.append(Muscle(f"m{k}", ends, wraps=(Wrap(f"s{k}", 0, side),)))
    return carriage(muscles, surfaces)


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
@pytest.mark.parametrize("side", [0, 1, -1])
def test_parallel_wraps_at_contact_and_side_changes(
    shape: WrapShape, side: Literal[0, 1, -1]
) -> None:
    """Check angles one rounding error before and after contact, and paths through the axis."""
    touching = 2 * math.acos(1 / 3)
    apart = np.concatenate([[0.0], np.logspace(-16, -1, 16)])
    kinks = [sign * angle for angle in (touching, math.pi) for sign in (1, -1)]
    angles = np.concatenate([kink + sign * apart for kink in kinks for sign in (1, -1)])
    robot = fan(shape, side, angles, 0.0 if shape == "sphere" else 0.07)
    lengths = MusclePaths(robot).evaluate(np.zeros(3)).lengths
    for length, paths in zip(lengths, single_muscle_robots(robot), strict=True):
        assert length == pytest.approx(paths.evaluate(np.zeros(3)).lengths[0], abs=1e-14)


def test_trace_does_not_change_results() -> None:
    """Results after drawing are bit-identical."""
    rng = np.random.default_rng(3)
    paths, q = MusclePaths(single_wraps(rng, 40, sides=(0, 1, -1))), rng.uniform(-0.3, 0.3, 3)
    lengths, L = (array.copy() for array in paths.evaluate(q))
    core: Core = paths._core
    core.trace(core.handle)
    again, L_again = core.array("lengths", 40), core.array("jacobian", 40, 3)
    np.testing.assert_array_equal(again, lengths)
    np.testing.assert_array_equal(L_again, L)
