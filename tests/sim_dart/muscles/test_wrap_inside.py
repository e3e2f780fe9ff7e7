"""Cables inside surfaces compared with MuJoCo, closed forms and convex optimisation."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from support.oracles.mujoco_wraps import MujocoWraps
from support.robots.path_checks import check_jacobian, total_forces
from support.robots.random_robots import random_robot
from support.robots.wrapped import FAR, carriage, single_wraps, wrapped_tree

from addin_sdfusion.robot import WORLD, Muscle, Pose, Robot, ViaPoint, Wrap, WrapSurface
from sim_dart import MusclePaths
from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native
STEP = 1e-6


def inside(robot: Robot) -> Robot:
    """Return the same muscles with inside wraps."""
    return robot.with_muscles(
        replace(m, wraps=tuple(replace(w, side=0, turns=0, inside=True) for w in m.wraps))
        for m in robot.muscles
    )


def straight_lengths(robot: Robot, q: FloatArray) -> FloatArray:
    """Return the distances of the ends of all muscles of a carriage."""
    ends = [[np.array(p.position) for p in m.via_points] for m in robot.muscles]
    return np.array([np.linalg.norm(b + q - a) for a, b in ends])


@pytest.mark.slow
def test_lengths_and_jacobian_equal_mujoco_inside_wraps() -> None:
    """Check 10,000 configurations with a side site at the centre, also with ends inside."""
    rng = np.random.default_rng(31)
    compared = touched = 0
    for scale in (1.0, 0.01, 30.0):
        robot = inside(single_wraps(rng, 200))
        sites = [np.zeros(3)] * len(robot.muscles)
        paths, mujoco = MusclePaths(scaled(robot, scale)), MujocoWraps(robot, sites)
        for _ in range(20):
            q = rng.uniform(-0.5, 0.5, 3)
            lengths = paths.evaluate(q * scale).lengths / scale
            np.testing.assert_allclose(lengths, mujoco.lengths(q), rtol=0, atol=1e-9)
            compared += len(lengths)
            touched += int((lengths > straight_lengths(robot, q) + 1e-9).sum())
    assert compared >= 10_000
    assert 0.5 < touched / compared < 0.95


def scaled(robot: Robot, scale: float) -> Robot:
    """Return the robot in another unit of length."""

    def times(vector: tuple[float, ...]) -> tuple[float, float, float]:
        x, y, z = (scale * value for value in vector)
        return x, y, z

    muscles = [
        replace(m, via_points=tuple(replace(p, position=times(p.position)) for p in m.via_points))
        for m in robot.muscles
    ]
    surfaces = tuple(
        replace(s, radius=scale * s.radius, pose=Pose(times(s.pose.position), s.pose.rpy))
        for s in robot.wrap_surfaces
    )
    return replace(robot.with_muscles(muscles), wrap_surfaces=surfaces)


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
@pytest.mark.parametrize("angle", [0.0, 0.3, 1.0, -1.6, 1.9])
def test_symmetric_path_touches_in_the_middle(shape: str, angle: float) -> None:
    """Both ends are at 3 R. The cable touches at half of the angle between them."""
    R, climb = 0.1, 0.0 if shape == "sphere" else 0.13
    half = abs(angle) / 2
    planar = 2 * math.hypot(3 * R * math.sin(half), 3 * R * math.cos(half) - R)
    robot = polar(shape, R, 3 * R, 3 * R, angle, climb)
    (length,) = MusclePaths(robot).evaluate(np.zeros(3)).lengths
    assert length == pytest.approx(math.hypot(planar, climb), abs=1e-14)
    (line,) = MusclePaths(robot).path_points(np.zeros(3))
    middle = (R * math.cos(angle / 2), R * math.sin(angle / 2), climb / 2)
    np.testing.assert_allclose(line[1], middle, atol=1e-14)


def polar(shape: str, R: float, ra: float, rb: float, angle: float, climb: float = 0.0) -> Robot:
    """Return a muscle between two points in polar coordinates about the z axis of the surface."""
    ends = (
        ViaPoint(WORLD, (ra, 0.0, 0.0)),
        ViaPoint(FAR, (rb * math.cos(angle), rb * math.sin(angle), climb)),
    )
    surface = WrapSurface("ring", WORLD, shape, R)  # type: ignore[arg-type]
    return carriage([Muscle("m", ends, wraps=(Wrap("ring", 0, inside=True),))], [surface])


def test_jacobian_is_the_derivative_of_the_lengths() -> None:
    rng = np.random.default_rng(32)
    robot = inside(single_wraps(rng, 200))
    paths = MusclePaths(robot)
    compared = 0
    for _ in range(20):
        q = rng.uniform(-0.5, 0.5, 3)
        compared += check_jacobian(paths, q, STEP)
    assert compared > 0.99 * 200 * 20 * 3


@pytest.mark.cases(3)
@pytest.mark.slow
@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
@pytest.mark.parametrize(
    ("begin", "end"),
    [((0.3, 0.1), (-0.5, 0.0)), ((0.0, 0.15), (0.0, 0.02)), ((0.12, -0.2), (-0.3, -0.2))],
    ids=["grazing", "an end moves in", "passing below"],
)
def test_length_is_continuous_at_first_contact_inside(
    shape: str, begin: tuple[float, float], end: tuple[float, float]
) -> None:
    """Lengths at neighbouring positions differ by at most their distance."""
    surface = WrapSurface("ring", WORLD, shape, 0.1)  # type: ignore[arg-type]
    ends = (ViaPoint(WORLD, (0.4, 0.13, 0.0)), ViaPoint(FAR, (0.0, 0.0, 0.02)))
    muscle = Muscle("m", ends, wraps=(Wrap("ring", 0, inside=True),))
    robot = carriage([muscle], [surface])
    paths, places = MusclePaths(robot), np.linspace([*begin, 0.0], [*end, 0.0], 20_001)
    lengths = np.array([paths.evaluate(q).lengths[0] for q in places])
    step = np.linalg.norm(places[1] - places[0])
    assert abs(np.diff(lengths)).max() <= step * (1 + 1e-9)
    bent = lengths > np.array([straight_lengths(robot, q)[0] for q in places]) + 1e-12
    assert bent.any()
    assert not bent.all()
    assert (lengths >= [straight_lengths(robot, q)[0] - 1e-14 for q in places]).all()


@pytest.mark.slow
def test_path_through_several_balls_is_the_shortest() -> None:
    """Compare with the convex problem of the smallest sum of distances over points in balls."""
    rng = np.random.default_rng(33)
    touched = 0
    for count in (2, 3):
        for _ in range(25):
            centres = np.linspace([-0.4, 0, 0], [0.4, 0, 0], count)
            centres = centres + rng.uniform(-0.25, 0.25, (count, 3)) * [0.2, 1, 1]
            radii = rng.uniform(0.02, 0.08, count)
            surfaces = [
                WrapSurface(f"b{k}", WORLD, "sphere", float(r), Pose(tuple(map(float, c))))
                for k, (c, r) in enumerate(zip(centres, radii, strict=True))
            ]
            ends = (ViaPoint(WORLD, (-1.0, 0.0, 0.1)), ViaPoint(FAR, (1.0, 0.1, 0.0)))
            wraps = tuple(Wrap(s.name, 0, inside=True) for s in surfaces)
            robot = carriage([Muscle("m", ends, wraps=wraps)], surfaces)
            (length,) = MusclePaths(robot).evaluate(np.zeros(3)).lengths
            expected = shortest(*(np.array(p.position) for p in ends), centres, radii)
            assert length == pytest.approx(expected, abs=1e-7)  # accuracy of the search
            touched += length > straight_lengths(robot, np.zeros(3))[0] + 1e-6
    assert touched > 40


def shortest(a: FloatArray, b: FloatArray, centres: FloatArray, radii: FloatArray) -> float:
    """Return the length of the shortest path from a to b through balls in order."""

    def length(flat: FloatArray) -> float:
        way = np.vstack([a, flat.reshape(-1, 3), b])
        return float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())

    within = {
        "type": "ineq",
        "fun": lambda flat: radii**2 - ((flat.reshape(-1, 3) - centres) ** 2).sum(axis=1),
    }
    found = minimize(
        length,
        centres.ravel(),
        method="SLSQP",
        constraints=within,
        options={"ftol": 1e-14, "maxiter": 500},
    )
    return float(found.fun)


@pytest.mark.parametrize("seed", range(4))
def test_forces_are_balanced_and_have_the_power_of_tensions(seed: int) -> None:
    """Check zero total force and torque, and the power -f . l', on random trees."""
    robot = inside(wrapped_tree(random_robot(seed), seed))
    paths, m, n = MusclePaths(robot), len(robot.muscles), len(robot.coordinates)
    rng = np.random.default_rng(seed)
    for _ in range(10):
        q = rng.uniform(-1.5, 1.5, n)
        pulls = paths.point_forces(q, np.ones(m))
        force, torque = total_forces(pulls, m)
        assert max(abs(force).max(), abs(torque).max()) < 1e-12
        check_jacobian(paths, q, STEP)


@pytest.mark.slow
def test_degenerate_positions_have_finite_lengths_and_jacobians() -> None:
    """Ends are on the surface, at its centre, equal, opposite, on one ray, or on the axis."""
    for shape in ("sphere", "cylinder"):
        for ra in (0.0, 0.1, 0.1 * (1 + 1e-15), 0.3):
            for rb in (0.0, 0.1, 0.2, 0.3):
                for angle in (0.0, 1e-12, math.pi / 2, math.pi - 1e-9, math.pi):
                    state = MusclePaths(polar(shape, 0.1, ra, rb, angle)).evaluate(np.zeros(3))
                    assert np.isfinite(state.lengths).all()
                    assert np.isfinite(state.jacobian).all()
