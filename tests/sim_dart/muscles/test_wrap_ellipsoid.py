"""Wraps over ellipsoids compared with spheres, elliptic integrals and polygons."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, minimize
from scipy.special import ellipeinc
from support.robots.wrapped import FAR, carriage, over_ellipsoids, vector

from addin_sdfusion.robot import WORLD, Muscle, Pose, Robot, ViaPoint, Wrap, WrapSurface
from addin_sdfusion.robot.model.rotations import rotation
from sim_dart import MusclePaths, Plant
from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native


def _muscle_over_ellipsoid(r: FloatArray, pose: Pose, a: FloatArray, b: FloatArray) -> Robot:
    """Return a muscle from the world over an ellipsoid to a carriage."""
    egg = WrapSurface("egg", WORLD, "ellipsoid", r[0], pose, half_axes=(r[1], r[2]))
    ends = (ViaPoint(WORLD, tuple(a)), ViaPoint(FAR, tuple(b)))
    return carriage([Muscle("m", ends, wraps=(Wrap("egg", 0),))], [egg])


def _length(r: FloatArray, a: FloatArray, b: FloatArray) -> float:
    """Return the length from a to b in the frame of the ellipsoid."""
    robot = _muscle_over_ellipsoid(np.array(r), Pose(), np.array(a), np.array(b))
    return float(MusclePaths(robot).evaluate(np.zeros(3)).lengths[0])


def _case(rng: np.random.Generator, ratio: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return half axes with a limited ratio, and two end points on opposite sides."""
    r = np.exp(rng.uniform(0.0, math.log(ratio), 3)) * rng.uniform(0.02, 0.5)
    ends = []
    towards = rng.normal(size=3)
    for sign in (1, -1):
        at = sign * towards + 0.4 * rng.normal(size=3)
        ends.append(r * at / np.linalg.norm(at) * rng.uniform(1.01, 2.0))
    return r, ends[0], ends[1]


@pytest.mark.slow
def test_ellipsoid_with_equal_half_axes_equals_sphere() -> None:
    rng = np.random.default_rng(0)
    for _ in range(40):
        _, a, b = _case(rng, 1.0)
        R, pose = float(rng.uniform(0.5, 0.99) * min(map(np.linalg.norm, (a, b)))), vector(rng, 2.0)
        robot = _muscle_over_ellipsoid(np.full(3, R), Pose((0.0, 0.0, 0.0), pose), a, b)
        ball = replace(robot, wrap_surfaces=(WrapSurface("egg", WORLD, "sphere", R),))
        for q in (np.zeros(3), rng.normal(size=3) * R, -b + 0.3 * R * rng.normal(size=3)):
            egg, sphere = (MusclePaths(each).evaluate(q) for each in (robot, ball))
            assert egg.lengths[0] == pytest.approx(sphere.lengths[0], rel=2e-15)
            np.testing.assert_allclose(egg.jacobian, sphere.jacobian, atol=5e-15)


def _ellipse(a: float, b: float, from_: float, to: float) -> float:
    """Return the length of an ellipse (a cos t, b sin t)."""
    m = 1.0 - (a / b) ** 2
    return b * float(ellipeinc(to, m) - ellipeinc(from_, m))


def _around_ellipse(a: float, b: float, x: float, y: float) -> float:
    """Return the length from (x, y) over the top of an ellipse to (-x, y)."""

    def off(t: float) -> float:
        return x * math.cos(t) / a + y * math.sin(t) / b - 1.0

    t = brentq(off, math.atan2(y / b, x / a), math.pi / 2, xtol=1e-15)
    tangent = math.hypot(x - a * math.cos(t), y - b * math.sin(t))
    return 2.0 * tangent + 2.0 * _ellipse(a, b, t, math.pi / 2)


@pytest.mark.parametrize(("a", "b", "c"), [(1.0, 0.7, 2.0), (0.4, 1.0, 1.2), (1.0, 1.0, 3.0)])
def test_paths_in_planes_of_symmetry(a: float, b: float, c: float) -> None:
    """The shortest path in the plane perpendicular to the longest half axis is over an ellipse."""
    for x, y in ((1.5, 0.2), (1.1, 0.6), (3.0, 0.1)):
        expected = _around_ellipse(a, b, x * a, y * b)
        assert _length((a, b, c), (x * a, y * b, 0.0), (-x * a, y * b, 0.0)) == pytest.approx(
            expected, rel=1e-13
        )


def _chords(r: FloatArray, a: FloatArray, b: FloatArray, parts: int, side: float) -> float:
    """Return the shortest path of two tangents and a number of chords.

    The mean square of the chords is minimised. It equals the squared mean if all have equal length.
    """
    ends = np.array([a / r, b / r])
    e2 = (ends**2).sum(axis=1)
    rho = np.sqrt(1.0 - 1.0 / e2)
    frames = [np.linalg.svd(end[None])[2][1:] for end in ends]

    def tangent(k: int, t: float) -> tuple[FloatArray, FloatArray]:
        c, s = math.cos(t), math.sin(t)
        at = r * (ends[k] / e2[k] + rho[k] * (c * frames[k][0] + s * frames[k][1]))
        return at, r * rho[k] * (c * frames[k][1] - s * frames[k][0])

    def total(z: FloatArray) -> tuple[float, FloatArray]:
        y = z[2:].reshape(-1, 3)
        norm = np.linalg.norm(y, axis=1, keepdims=True)
        (p, dp), (q, dq) = (tangent(k, z[k]) for k in (0, 1))
        x = np.vstack([p, r * y / norm, q])
        d = np.diff(x, axis=0)
        root = math.sqrt(parts * (d**2).sum())
        by_x = np.zeros_like(x)
        by_x[:-1] -= parts / root * d
        by_x[1:] += parts / root * d
        by_y = r * by_x[1:-1] / norm
        by_y -= (by_y * y).sum(axis=1, keepdims=True) * y / norm**2
        spans = [np.linalg.norm(p - a), np.linalg.norm(q - b)]
        by_p = by_x[0] + (p - a) / spans[0]
        by_q = by_x[-1] + (q - b) / spans[1]
        return spans[0] + spans[1] + root, np.array([by_p @ dp, by_q @ dq, *by_y.ravel()])

    across = np.cross(ends[0], ends[1])
    middle = np.cross(across, ends[1] - ends[0]) * side
    angles = [math.atan2(middle @ f[1], middle @ f[0]) for f in frames]
    begin, end = (tangent(k, angles[k])[0] / r for k in (0, 1))
    share = np.linspace(0.0, 1.0, parts + 1)[1:-1, None]
    start = begin + (end - begin) * share + 0.2 * middle / np.linalg.norm(middle)
    found = minimize(total, [*angles, *start.ravel()], jac=True, method="BFGS",
                     options={"gtol": 1e-11, "maxiter": 3000})  # fmt: skip
    return float(found.fun)


def _shortest(r: FloatArray, a: FloatArray, b: FloatArray) -> float:
    """Return the length extrapolated from chords, whose error is quadratic in their length."""
    side = min((1.0, -1.0), key=lambda side: _chords(r, a, b, 8, side))
    coarse, fine = (_chords(r, a, b, parts, side) for parts in (12, 24))
    return fine + (fine - coarse) / 3.0


@pytest.mark.slow
def test_paths_equal_shortest_polygons() -> None:
    rng = np.random.default_rng(3)
    touched = 0
    for ratio in (1.5, 2.0, 3.0, 4.0):
        r, a, b = _case(rng, ratio)
        length = _length(r, a, b)
        if length == pytest.approx(math.dist(a, b), rel=1e-6):
            continue
        touched += 1
        assert length == pytest.approx(_shortest(r, a, b), rel=3e-6)
    assert touched >= 3


def test_gradient_equals_differences_of_the_length() -> None:
    """Check both ends, shrunk ellipsoids, and random poses."""
    rng = np.random.default_rng(4)
    most = 0.0
    for k in range(40):
        r, a, b = _case(rng, 3.0)
        if k % 4 == 0:
            b *= 0.9 / np.linalg.norm(b / r)  # inside
        pose = Pose(vector(rng, 0.5), vector(rng, 3.0))
        R, centre = np.array(rotation(pose.rpy)), np.array(pose.position)
        paths = MusclePaths(_muscle_over_ellipsoid(r, pose, centre + R @ a, centre + R @ b))
        L = paths.evaluate(np.zeros(3)).jacobian[0].copy()
        for j, h in enumerate(1e-3 * r.min() * np.eye(3)):
            near, far = ([paths.evaluate(s * m * h).lengths[0] for s in (1, -1)] for m in (1, 2))
            slope = (8 * (near[0] - near[1]) - (far[0] - far[1])) / (12 * h[j])
            most = max(most, abs(L[j] - slope))
    assert most < 1e-8


def test_length_depends_only_on_the_pose() -> None:
    rng = np.random.default_rng(5)
    r, a, b = _case(rng, 3.0)
    robot = _muscle_over_ellipsoid(r, Pose(), a, b)
    poses = 0.3 * r.min() * rng.normal(size=(20, 3))
    fresh = [MusclePaths(robot).evaluate(q).lengths[0] for q in poses]
    paths = MusclePaths(robot)
    for k in rng.permutation(60) % 20:
        assert paths.evaluate(poses[k]).lengths[0] == fresh[k]


def test_length_is_smooth_at_first_contact() -> None:
    """Move across the pose in which the straight line touches the ellipsoid."""
    a, b = np.array([-1.0, 0.0, 0.1]), np.array([1.0, 0.0, 0.1])
    paths = MusclePaths(_muscle_over_ellipsoid(np.array([0.3, 0.2, 0.1]), Pose(), a, b))
    for z in (1e-3, 1e-6, 1e-9):
        clear, touching = (paths.evaluate([0.0, 0.0, s * z]).lengths[0] for s in (1, -1))
        assert clear == pytest.approx(math.hypot(2.0, z), rel=1e-15)
        assert 0.0 <= touching - math.hypot(2.0, z) < z**2


def test_drawn_line_has_the_length_of_the_path() -> None:
    rng = np.random.default_rng(6)
    for _ in range(10):
        r, a, b = _case(rng, 2.0)
        paths = MusclePaths(_muscle_over_ellipsoid(r, Pose(), a, b))
        length = paths.evaluate(np.zeros(3)).lengths[0]
        line = paths.path_points(np.zeros(3))[0]
        drawn = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
        assert drawn == pytest.approx(length, rel=2e-3)
        assert (((line / r) ** 2).sum(axis=1) > 1.0 - 1e-4).all()


def _two_surfaces(shape: str, rng: np.random.Generator) -> Robot:
    egg = WrapSurface("egg", WORLD, "ellipsoid", 0.3, Pose((-0.5, 0.0, 0.0)), half_axes=(0.2, 0.15))
    axes = (0.15, 0.25) if shape == "ellipsoid" else None
    other = WrapSurface("other", "link_1", shape, 0.2, Pose((0.6, 0.1, 0.0)), half_axes=axes)  # type: ignore[arg-type]
    ends = (ViaPoint(WORLD, (-1.2, 0.0, -0.1)), ViaPoint(FAR, (1.3, 0.05, 0.1)))
    return carriage([Muscle("m", ends, wraps=(Wrap("egg", 0), Wrap("other", 0)))], [egg, other])


@pytest.mark.parametrize("shape", ["sphere", "cylinder", "ellipsoid"])
def test_with_another_surface_in_the_segment(shape: str) -> None:
    """The path is taut, has the correct gradient, and is not longer than over a via point."""
    rng = np.random.default_rng(7)
    robot = _two_surfaces(shape, rng)
    paths = MusclePaths(robot)
    for q in 0.05 * rng.normal(size=(4, 3)):
        state = paths.evaluate(q)
        length, L = state.lengths[0], state.jacobian[0].copy()
        for j, h in enumerate(1e-4 * np.eye(3)):
            near, far = (
                [paths.evaluate(q + s * m * h).lengths[0] for s in (1, -1)] for m in (1, 2)
            )
            slope = (8 * (near[0] - near[1]) - (far[0] - far[1])) / 12e-4
            assert L[j] == pytest.approx(slope, abs=1e-8)
        for middle in rng.normal(size=(5, 3)) * (0.05, 0.3, 0.3):
            muscle = robot.muscles[0]
            points = (muscle.via_points[0], ViaPoint(WORLD, tuple(middle)), muscle.via_points[1])
            split = replace(muscle, via_points=points, wraps=(Wrap("egg", 0), Wrap("other", 1)))
            longer = MusclePaths(robot.with_muscles([split])).evaluate(q).lengths[0]
            assert length <= longer + 1e-12


@pytest.mark.parametrize("name", ["one", "bar", "quadrant"])
def test_energy_of_a_swinging_robot_is_constant(name: str) -> None:
    """The error of the total energy with constant tensions is of order h^4."""
    robot = over_ellipsoids()
    robot = robot.with_muscles([muscle for muscle in robot.muscles if muscle.name == name])
    paths, f = MusclePaths(robot), np.array([20.0])
    errors = []
    for step in (1e-2, 5e-3):
        plant = Plant(robot, step=step, integrator="rk4", energy=True)
        plant.reset(np.array([0.2, -0.1, 0.3]), np.array([0.5, -0.3, 0.4]))
        energies = []
        for _ in range(round(0.2 / step)):
            plant.step(f)
            energy = plant.energy
            stored = f @ paths.evaluate(plant.q).lengths
            energies.append(energy.kinetic + energy.potential + stored)
        errors.append(np.ptp(energies))
    assert errors[0] < 1e-7
    assert errors[1] < errors[0] / 8.0
