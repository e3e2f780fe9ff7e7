"""Tackles and differential pulleys: cables with several falls or branches."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support.robots.one_link import one_link
from support.robots.wrapped import carriage

from addin_sdfusion.robot import (
    WORLD,
    Branch,
    Inertia,
    Muscle,
    Pose,
    Robot,
    ViaPoint,
    Wrap,
    WrapSurface,
    check,
    prismatic,
    read_robot,
    write_sdf,
)
from sim_dart import CoreDynamics, Plant
from sim_dart.core.arrays import FloatArray

RADIUS, DEPTH, MU, T = 0.05, 1.2, 0.1, 30.0


def tackle(falls: int, friction: float = 0.0) -> Robot:
    """Return a tackle: a block on rails below a fixed block, with falls at x = 0, 2 R, 4 R, ...

    The cable starts at the upper block. It ends at the lower block for an odd number of falls. Via
    points are the contact points of the sheaves.
    """
    surfaces, wraps, path = [], [], [ViaPoint(WORLD, (0.0, 0.0, 0.0))]
    for k in range(1, falls + 1):
        link, x = "a" if k % 2 else WORLD, 2 * (k - 1) * RADIUS
        path.append(ViaPoint(link, (x, 0.0, 0.0)))
        if k == falls:
            break
        place = Pose((x + RADIUS, 0.0, 0.0), (math.pi / 2, 0.0, 0.0))
        surfaces.append(WrapSurface(f"s{k}", link, "cylinder", RADIUS, place))
        wraps.append(Wrap(f"s{k}", len(path) - 1, side=1 if k % 2 else -1))
        path.append(ViaPoint(link, (x + 2 * RADIUS, 0.0, 0.0)))
    muscle = Muscle("m", tuple(path), 0.0, 1e4, wraps=tuple(wraps), friction=friction)
    inertia = Inertia(5.0, (0.0, 0.0, 0.0), 1.0, 1.0, 1.0)
    return one_link(inertia, [muscle], surfaces, prismatic((0.0, 0.0, -1.0)), initial=DEPTH)


@pytest.mark.parametrize("falls", range(1, 8))
def test_tackle_with_n_falls_has_n_times_the_force_and_length(falls: int, tmp_path: Path) -> None:
    """Check also the robot read from its file, with half a turn over each of n - 1 sheaves."""
    robot = tackle(falls)
    assert [f for f in check(robot) if f.is_error] == []
    write_sdf(robot, tmp_path)
    for each in (robot, read_robot(tmp_path)):
        dynamics = CoreDynamics(each)
        for depth in (DEPTH, 0.4):
            length = falls * depth + (falls - 1) * math.pi * RADIUS
            assert dynamics.muscle_lengths([depth])[0] == pytest.approx(length, rel=1e-12)
            assert dynamics.muscle_jacobian([depth])[0, 0] == pytest.approx(falls, rel=1e-12)


@pytest.mark.parametrize("falls", [2, 3, 5])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_friction_in_a_tackle(falls: int, way: float) -> None:
    """The tension in fall k is T exp(mu pi k) or T exp(-mu pi k).

    Via points are on the sheaves up to rounding, so contact angles are accurate to its square root.
    """
    plant = Plant(tackle(falls, MU), step=1e-3)
    plant.reset([DEPTH])
    state, count = plant.get_state(), len(plant.muscle_state_names)
    state[2], state[3 : 3 + count] = 0.3 * way, way
    plant.set_state(state)
    plant.step([T])
    pulled = 5.0 * (9.81 - (plant.qd[0] - 0.3 * way) / 1e-3)
    expected = T * sum(math.exp(way * MU * math.pi * k) for k in range(falls))
    assert pulled == pytest.approx(expected, rel=1e-7)
    far = T * math.exp(way * MU * math.pi * (falls - 1))
    assert plant.far_tensions[0] == pytest.approx(far, rel=1e-7)


def generalised_forces(robot: Robot, tension: float, q: FloatArray) -> FloatArray:
    """-L'f."""
    return -CoreDynamics(robot).muscle_jacobian(q)[0] * tension


def test_differential_pulley_has_one_tension() -> None:
    """Both ends of a cable over a floating pulley have half of the force on the pulley."""
    ends = [("link_0", (1.0, 0.0, 0.0)), ("link_1", (0.0, 1.0, 0.0))]
    path = [ViaPoint(WORLD, (0.0, 0.0, 0.0)), ViaPoint(*ends[0])]
    path += [ViaPoint(WORLD, (0.0, 0.0, 0.0)), ViaPoint(*ends[1])]
    branches = (Branch(0, 2.0), Branch(2, 2.0))
    robot = carriage([Muscle("m", tuple(path), 0.0, 1e3, branches=branches)], [])
    q = np.array([0.2, 0.3, 0.0])
    first, second = np.array([1.2, 0.0, 0.0]), np.array([0.2, 1.3, 0.0])
    length = (np.linalg.norm(first) + np.linalg.norm(second)) / 2
    assert CoreDynamics(robot).muscle_lengths(q)[0] == pytest.approx(length, rel=1e-14)
    pull = -T / 2 * first / np.linalg.norm(first), -T / 2 * second / np.linalg.norm(second)
    expected = [pull[0][0] + pull[1][0], pull[1][1], 0.0]  # link_1 is mounted on link_0
    np.testing.assert_allclose(generalised_forces(robot, T, q), expected, rtol=1e-13, atol=1e-13)
