"""One surface in a segment compared with MuJoCo, closed forms and finite differences."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from support.oracles.mujoco_wraps import MujocoWraps
from support.robots.path_checks import check_jacobian
from support.robots.wrapped import FAR, carriage, single_wraps

from addin_sdfusion.robot import WORLD, Muscle, Pose, Robot, ViaPoint, Wrap, WrapSurface
from addin_sdfusion.robot.model.rotations import rotation
from sim_dart import MusclePaths
from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native
STEP = 1e-6


class SurfaceEnds:
    """Ends of the muscles of a carriage in the frames of their surfaces, at one q."""

    def __init__(self, robot: Robot, q: FloatArray) -> None:
        self.R = np.array([surface.radius for surface in robot.wrap_surfaces])
        self.is_sphere = np.array([s.shape == "sphere" for s in robot.wrap_surfaces])
        ends = []
        for k in (0, 1):
            points = [np.array(m.via_points[k].position) + k * q for m in robot.muscles]
            ends.append(
                [
                    np.array(rotation(s.pose.rpy)).T @ (p - s.pose.position)
                    for p, s in zip(points, robot.wrap_surfaces, strict=True)
                ]
            )
        self.A, self.B = np.array(ends[0]), np.array(ends[1])
        flat = np.where(self.is_sphere[:, None], 1.0, [1.0, 1.0, 0.0])
        self.a, self.b = self.A * flat, self.B * flat
        self.inner = np.minimum(np.linalg.norm(self.a, axis=1), np.linalg.norm(self.b, axis=1))


def centre_side(robot: Robot, rng: np.random.Generator) -> list[FloatArray]:
    """Return a distant point on a random side of each surface; near points select inside wraps."""
    directions = rng.normal(size=(len(robot.muscles), 3)) * [1.0, 1.0, 0.0]
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return [1e3 * s.radius * d for s, d in zip(robot.wrap_surfaces, directions, strict=True)]


@pytest.mark.slow
def test_shorter_path_equals_mujoco() -> None:
    """Check 10,000 configurations with both ends outside, which MuJoCo requires."""
    rng = np.random.default_rng(1)
    compared = wrapped = 0
    for _ in range(5):
        robot = single_wraps(rng, 200)
        paths, mujoco = MusclePaths(robot), MujocoWraps(robot)
        for _ in range(20):
            q = rng.uniform(-0.5, 0.5, 3)
            seen = SurfaceEnds(robot, q)
            outside = seen.inner > seen.R
            lengths, expected = paths.evaluate(q).lengths, mujoco.lengths(q)
            np.testing.assert_allclose(lengths[outside], expected[outside], rtol=0, atol=1e-9)
            compared += int(outside.sum())
            wrapped += int((lengths > np.linalg.norm(seen.B - seen.A, axis=1) + 1e-9).sum())
    assert compared > 10_000
    assert wrapped > 1000


@pytest.mark.slow
def test_specified_sides_equal_mujoco_side_sites() -> None:
    """Compare the rotation sense of cables with side sites of MuJoCo.

    MuJoCo uses the longer path if the site is opposite to both ends. Two cases differ and are
    skipped: the straight line has no contact but is on the other side, or the straight parts cross.
    """
    rng = np.random.default_rng(2)
    compared = wrapped = 0
    for _ in range(8):
        robot = single_wraps(rng, 200)
        sites = centre_side(robot, rng)
        mujoco = MujocoWraps(robot, sites)
        senses = {
            s: MusclePaths(
                robot.with_muscles(
                    replace(m, wraps=(replace(m.wraps[0], side=s),)) for m in robot.muscles
                )
            )
            for s in (1, -1)
        }
        for _ in range(20):
            q = rng.uniform(-0.5, 0.5, 3)
            seen, expected = SurfaceEnds(robot, q), mujoco.lengths(q)
            lengths = {s: paths.evaluate(q).lengths.copy() for s, paths in senses.items()}
            sides, held = sides_of_sites(seen, sites)
            found = np.where(sides > 0, lengths[1], lengths[-1])
            np.testing.assert_allclose(found[held], expected[held], rtol=0, atol=1e-9)
            compared += int(held.sum())
            straight = np.linalg.norm(seen.B - seen.A, axis=1)
            wrapped += int((found[held] > straight[held] + 1e-9).sum())
    assert compared > 10_000
    assert wrapped > 1000


def sides_of_sites(
    seen: SurfaceEnds, sites: list[FloatArray]
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the sense of MuJoCo about each z axis, and whether it can be compared."""
    sides, held = [], []
    for k, site in enumerate(sites):
        x = np.cross(seen.a[k], seen.b[k])
        normal = x / np.linalg.norm(x) if seen.is_sphere[k] else np.array([0.0, 0.0, 1.0])
        e1 = seen.a[k] / np.linalg.norm(seen.a[k])
        e2 = np.cross(normal, e1)
        a, b, toward = (complex(v @ e1, v @ e2) for v in (seen.a[k], seen.b[k], site))
        shorter = 1 if (a.conjugate() * b).imag >= 0 else -1
        sense = -shorter if is_between(-a, toward, -b) else shorter
        foot = a + min(1.0, max(0.0, -along(a, b - a) / abs(b - a))) * (b - a)
        is_clear = abs(foot) >= seen.R[k]
        touch, lift = tangent_points(a, b, float(seen.R[k]), sense)
        sides.append(sense * (-1 if seen.is_sphere[k] and normal[2] < 0 else 1))
        is_outside = bool(seen.inner[k] > seen.R[k])
        on_side = not is_clear or along(foot, toward) >= 0
        held.append(is_outside and on_side and (is_clear or not do_cross(a, touch, b, lift)))
    return np.array(sides), np.array(held)


def tangent_points(a: complex, b: complex, R: float, sense: int) -> tuple[complex, complex]:
    """Return the first and last contact point of a cable from a to b on a circle."""
    from_a = math.acos(min(1.0, R / abs(a)))
    from_b = math.acos(min(1.0, R / abs(b)))
    return R * a / abs(a) * cmath.rect(1, sense * from_a), R * b / abs(b) * cmath.rect(
        1, -sense * from_b
    )


def is_between(a: complex, direction: complex, b: complex) -> bool:
    """Return whether a direction is inside of the smaller angle between a and b."""
    turn = (a.conjugate() * b).imag
    return (a.conjugate() * direction).imag * turn >= 0 and (
        direction.conjugate() * b
    ).imag * turn >= 0


def along(v: complex, direction: complex) -> float:
    """Return the component of v in a direction."""
    return (v * direction.conjugate()).real / abs(direction)


def do_cross(a: complex, p: complex, b: complex, q: complex) -> bool:
    """Return whether both straight parts cross, for which MuJoCo uses the other side."""
    d, e = p - a, q - b
    det = (d.conjugate() * e).imag
    if det == 0:
        return False
    s = ((b - a).conjugate() * e).imag / det
    t = ((b - a).conjugate() * d).imag / det
    return 0 <= s <= 1 and 0 <= t <= 1


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
@pytest.mark.parametrize("side", [0, 1, -1])
@pytest.mark.parametrize("turns", [0, 1, 3])
def test_lengths_in_closed_form(shape: str, side: int, turns: int) -> None:
    """Ends are at distances 2 R and 3 R, with an axial distance of R for a cylinder."""
    R, climb = 0.1, 0.0 if shape == "sphere" else 0.1
    free = math.acos(1 / 2) + math.acos(1 / 3)
    tangents = math.sqrt(3.0) * R + math.sqrt(8.0) * R
    for angle in np.radians([-179.0, -140.0, 135.0, 150.0, 179.0]):
        turned = abs(angle) if side in (0, np.sign(angle)) else 2 * math.pi - abs(angle)
        planar = tangents + R * (turned - free + 2 * math.pi * turns)
        robot = polar(shape, R, 2 * R, 3 * R, float(angle), climb, side, turns)
        (length,) = MusclePaths(robot).evaluate(np.zeros(3)).lengths
        assert length == pytest.approx(math.hypot(planar, climb), abs=1e-14)


def polar(
    shape: str,
    R: float,
    ra: float,
    rb: float,
    angle: float,
    climb: float = 0.0,
    side: int = 0,
    turns: int = 0,
    length: float = math.inf,
) -> Robot:
    """Return a muscle between two points in polar coordinates about the z axis of the surface."""
    ends = (
        ViaPoint(WORLD, (ra, 0.0, 0.0)),
        ViaPoint(FAR, (rb * math.cos(angle), rb * math.sin(angle), climb)),
    )
    surface = WrapSurface("round", WORLD, shape, R, length=length)  # type: ignore[arg-type]
    wrap = Wrap("round", 0, side, turns)  # type: ignore[arg-type]
    return carriage([Muscle("m", ends, wraps=(wrap,))], [surface])


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"sides": (1, -1)},
        {"sides": (0, 1, -1), "turns": (1, 2)},
        {"lengths": (0.1, 0.3)},
        {"sides": (1, -1), "lengths": (0.1, 0.3)},
    ],
    ids=["shorter", "sides", "turns", "ends", "ends-and-sides"],
)
def test_jacobian_is_the_derivative_of_the_lengths(options: dict[str, tuple[float, ...]]) -> None:
    """Compare except if a kink is between both evaluated lengths."""
    rng = np.random.default_rng(3)
    robot = single_wraps(rng, 200, **options)  # type: ignore[arg-type]
    paths = MusclePaths(robot)
    compared = 0
    for _ in range(20):
        q = rng.uniform(-0.5, 0.5, 3)
        compared += check_jacobian(paths, q, STEP)
    assert compared > 0.995 * 200 * 20 * 3


def event_interval(is_before: Callable[[float], bool]) -> tuple[float, float]:
    """Return two neighbouring numbers from 0 to 1, before and after an event."""
    low, high = 0.0, 1.0
    assert is_before(low)
    assert not is_before(high)
    while (middle := 0.5 * (low + high)) not in (low, high):
        low, high = (middle, high) if is_before(middle) else (low, middle)
    return low, high


def length_jump(
    robot: Robot, begin: FloatArray, end: FloatArray, is_before: Callable[[FloatArray, float], bool]
) -> float:
    """Return the jump of the first muscle length at an event."""
    paths = MusclePaths(robot)

    def length(t: float) -> float:
        return float(paths.evaluate(begin + t * (end - begin)).lengths[0])

    def before(t: float) -> bool:
        return is_before(begin + t * (end - begin), length(t))

    low, high = event_interval(before)
    return abs(length(high) - length(low))


def straight(robot: Robot, q: FloatArray) -> float:
    start, end = (np.array(point.position) for point in robot.muscles[0].via_points)
    return float(np.linalg.norm(end + q - start))


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
@pytest.mark.parametrize("side", [0, 1, -1])
def test_length_is_smooth_at_contact_and_lift_off(shape: str, side: int) -> None:
    """Move the straight line from contact to no contact on the side of the cable."""
    up = 1.0 if side >= 0 else -1.0
    robot = polar(shape, 0.1, 0.3, 0.3, math.pi - up * 0.2, 0.0 if shape == "sphere" else 0.1, side)
    begin, end = np.array([0.0, 0.0, 0.0]), np.array([0.0, up * 0.4, 0.0])
    jump = length_jump(robot, begin, end, lambda q, length: length > straight(robot, q) + 1e-13)
    assert jump < 1e-9


def test_length_is_continuous_if_the_shorter_path_changes_sides() -> None:
    """The straight line intersects the axis."""
    for shape in ("sphere", "cylinder"):
        robot = polar(shape, 0.1, 0.3, 0.3, math.pi - 0.1)
        begin, end = np.zeros(3), np.array([0.0, -0.1, 0.0])
        y = robot.muscles[0].via_points[1].position[1]
        assert length_jump(robot, begin, end, lambda q, _, y=y: bool(y + q[1] > 0)) < 1e-9


def test_specified_side_is_smooth_at_half_a_turn_and_jumps_at_lift_off() -> None:
    """The documented jump is from the longer path to the straight line."""
    robot = polar("cylinder", 0.1, 0.3, 0.3, math.pi - 0.1, side=1)
    y = robot.muscles[0].via_points[1].position[1]
    end = np.array([0.0, -0.3, 0.0])
    assert length_jump(robot, np.zeros(3), end / 3, lambda q, _: bool(y + q[1] > 0)) < 1e-9
    jump = length_jump(
        robot, np.zeros(3), end, lambda q, length: length > straight(robot, q) + 1e-13
    )
    assert jump > 0.1


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_end_point_inside_the_surface(shape: str) -> None:
    """The length is smooth at the surface, straight at the centre, and finite inside."""
    robot = polar(shape, 0.1, 0.3, 0.11, math.pi - 0.3)
    position = np.array(robot.muscles[0].via_points[1].position)
    end = -position

    def is_outside(q: FloatArray, _: float) -> bool:
        return bool(np.linalg.norm(position + q) > 0.1)

    assert length_jump(robot, np.zeros(3), end, is_outside) < 1e-9
    paths = MusclePaths(robot)
    at_centre = paths.evaluate(end)
    assert at_centre.lengths[0] == pytest.approx(0.3, abs=1e-12)
    assert np.isfinite(at_centre.jacobian).all()
    rng = np.random.default_rng(5)
    for _ in range(200):
        inside = rng.normal(size=3)
        inside *= rng.uniform(0.01, 0.099) / np.linalg.norm(inside)
        q = inside - position
        L = paths.evaluate(q).jacobian[0].copy()
        for j, e in enumerate(np.eye(3) * 1e-7):
            ahead = paths.evaluate(q + e).lengths[0]
            slope = (ahead - paths.evaluate(q - e).lengths[0]) / 2e-7
            assert L[j] == pytest.approx(slope, abs=1e-6)


def test_length_is_continuous_at_the_end_of_a_cylinder() -> None:
    """The length decreases to the straight length within one radius."""
    R, half = 0.1, 0.15
    robot = polar("cylinder", R, 0.3, 0.3, 2.8, length=2 * half)
    lifted = [
        replace(point, position=(*point.position[:2], 0.0)) for point in robot.muscles[0].via_points
    ]
    lengths = []
    heights = np.linspace(0.0, 0.4, 4001)
    for z in heights:
        points = tuple(replace(p, position=(*p.position[:2], float(z))) for p in lifted)
        moved = robot.with_muscles([replace(robot.muscles[0], via_points=points)])
        if len(lengths) % 40 == 0 or abs(z - half) < 1e-3 or abs(z - half - R) < 1e-3:
            lengths.append((z, MusclePaths(moved).evaluate(np.zeros(3)).lengths[0]))
    over = lengths[0][1]
    free = np.linalg.norm(np.subtract(lifted[1].position, lifted[0].position))
    for z, length in lengths:
        assert free - 1e-12 <= length <= over + 1e-12
        if z <= half:
            assert length == pytest.approx(over, abs=1e-12)
        if z >= half + R:
            assert length == pytest.approx(free, abs=1e-12)
    robot = polar("cylinder", R, 0.3, 0.3, 2.8, climb=0.05, length=2 * half)
    for edge in (2 * (half - 0.025), 2 * (half + R - 0.025)):  # half of z is at the edge
        begin, end = np.array([0.0, 0.0, edge - 0.1]), np.array([0.0, 0.0, edge + 0.1])
        jump = length_jump(robot, begin, end, lambda q, _, edge=edge: bool(q[2] < edge))
        assert jump < 1e-9


def test_the_same_pose_has_the_same_length() -> None:
    rng = np.random.default_rng(6)
    robot = single_wraps(rng, 50, sides=(0, 1, -1))
    paths, q = MusclePaths(robot), np.array([0.1, -0.2, 0.3])
    lengths = paths.evaluate(q).lengths.copy()
    for _ in range(10):
        paths.evaluate(rng.uniform(-1, 1, 3))
    np.testing.assert_array_equal(paths.evaluate(q).lengths, lengths)


@pytest.mark.slow
def test_degenerate_positions_have_finite_lengths_and_jacobians() -> None:
    """Ends are on the surface, at its centre, equal, opposite, or on the axis."""
    places = [(0.0, 0.0), (0.1, 0.1), (0.1, 0.0), (0.0, 0.3), (0.3, 0.3), (0.1, 0.3)]
    for shape in ("sphere", "cylinder"):
        for ra, rb in places:
            for angle in (0.0, math.pi, -math.pi / 2):
                for side, turns in ((0, 0), (1, 0), (-1, 0), (0, 1), (1, 2)):
                    robot = polar(shape, 0.1, ra, rb, angle, 0.0, side, turns)
                    state = MusclePaths(robot).evaluate(np.zeros(3))
                    assert np.isfinite(state.lengths).all()
                    assert np.isfinite(state.jacobian).all()


def test_length_is_invariant_to_rigid_motion() -> None:
    """Move the surface together with its muscle."""
    rng = np.random.default_rng(8)
    for shape in ("sphere", "cylinder"):
        robot = polar(shape, 0.1, 0.3, 0.2, 2.5, 0.1, 1, 0, 0.5)
        muscle, surface = robot.muscles[0], robot.wrap_surfaces[0]
        (expected,) = MusclePaths(robot).evaluate(np.zeros(3)).lengths
        for _ in range(20):
            rpy = tuple(map(float, rng.uniform(-3, 3, 3)))
            R, shift = np.array(rotation(rpy)), rng.uniform(-1, 1, 3)
            points = tuple(
                ViaPoint(p.link, tuple(map(float, R @ p.position + shift)))
                for p in muscle.via_points
            )
            pose = Pose(tuple(map(float, shift)), rpy)
            moved = carriage([replace(muscle, via_points=points)], [replace(surface, pose=pose)])
            (length,) = MusclePaths(moved).evaluate(np.zeros(3)).lengths
            assert length == pytest.approx(expected, abs=1e-13)
