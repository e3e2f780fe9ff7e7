"""Cost of wrap surfaces, as a ratio within one run."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.interleaved import interleaved, record
from support.robots.robots import chain

from addin_sdfusion.robot import Pose, Robot, Wrap, WrapSurface
from addin_sdfusion.robot.model.muscle import WrapShape
from sim_dart import MusclePaths

LIMIT = 1.6
RADII = {"clear": 0.002, "some": 0.0062, "all": 0.015}
"""Radii at which no muscle, some muscles, or all muscles touch their surface."""
POSES = np.random.default_rng(0).uniform(-0.1, 0.1, (20, 20))


def wrapped_chain(shape: WrapShape, radius: float) -> Robot:
    """Return the chain of 60 muscles, each with a wrap surface in its middle segment."""
    robot = chain()
    muscles, surfaces = [], []
    for muscle in robot.muscles:
        here = muscle.via_points[1]
        x, y, _ = here.position
        centre = Pose((0.8 * x, 0.8 * y, -0.1), (math.pi / 2, 0.0, math.atan2(y, x)))
        name = f"{muscle.name}_surface"
        surfaces.append(WrapSurface(name, here.link, shape, radius, centre))
        muscles.append(replace(muscle, wraps=(Wrap(name, 1),)))
    return replace(robot.with_muscles(muscles), wrap_surfaces=tuple(surfaces))


def kernel(paths: MusclePaths) -> Callable[[], None]:
    """Return a call that computes l, L and torques at 20 poses."""
    core, poses = paths._core, [q.tobytes() for q in POSES]
    move, pull, handle, forces = core.move, core.pull, core.handle, np.ones(60).tobytes()

    def run() -> None:
        for q in poses:
            move(handle, q)
            pull(handle, forces)

    return run


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
@pytest.mark.parametrize("touching", RADII)
def test_cost_of_one_surface_per_muscle(shape: WrapShape, touching: str) -> None:
    """Compare 60 muscles with 4 points on 20 joints, with one surface each and without."""
    straight, wrapped = MusclePaths(chain()), MusclePaths(wrapped_chain(shape, RADII[touching]))
    share = np.mean(
        [wrapped.evaluate(q).lengths > straight.evaluate(q).lengths + 1e-12 for q in POSES]
    )
    low, high = {"clear": (0.0, 0.0), "some": (0.2, 0.8), "all": (1.0, 1.0)}[touching]
    assert low <= share <= high
    seconds = interleaved(
        {"straight": kernel(straight), "wrapped": kernel(wrapped)}, calls=5, rounds=600
    )
    ratio = seconds["wrapped"] / seconds["straight"]
    record(
        f"muscle kernel with a {shape} a muscle, {touching} touched",
        ratio_to_straight=ratio,
        share_touched=float(share),
        wrapped_us=seconds["wrapped"] / len(POSES) * 1e6,
        straight_us=seconds["straight"] / len(POSES) * 1e6,
    )
    assert ratio <= LIMIT
