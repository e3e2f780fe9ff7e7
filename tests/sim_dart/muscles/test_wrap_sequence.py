"""Several surfaces in one segment: taut and smooth paths, and closed forms."""

from __future__ import annotations

import cmath
import math
from itertools import pairwise, product

import numpy as np
import pytest
from scipy.optimize import minimize
from support.cases import sample_cases
from support.robots.path_checks import check_jacobian
from support.robots.wrapped import FAR, carriage, sequences

from addin_sdfusion.robot import WORLD, Muscle, Pose, Robot, ViaPoint, Wrap, WrapSurface
from sim_dart import MusclePaths

pytestmark = pytest.mark.native

KINDS = [
    {"shapes": ("sphere",)},
    {"shapes": ("cylinder",)},
    {},
    {"shapes": ("cylinder",), "sides": (1, -1)},
    {"pulley": True},
]
NAMES = ["spheres", "cylinders", "both", "sides", "pulley"]
STEP = 1e-6


def belt(
    circles: list[tuple[complex, float, int]], start: complex, end: complex, climb: float
) -> float:
    """Return the length of a cable over parallel cylinders on given sides.

    The direction of a common tangent of two circles with senses s and t is the direction of their
    centres, rotated by asin((s R - t r) / distance).
    """
    stations = [(start, 0.0, 1), *circles, (end, 0.0, 1)]
    planar, directions = 0.0, []
    for (c, R, s), (d, r, t) in pairwise(stations):
        gap, offset = abs(d - c), s * R - t * r
        planar += math.sqrt(gap**2 - offset**2)
        directions.append(cmath.phase(d - c) + math.asin(offset / gap))
    for (_, R, s), (before, after) in zip(circles, pairwise(directions), strict=True):
        planar += R * ((s * (after - before)) % (2 * math.pi))
    return math.hypot(planar, climb)


def parallel(circles: list[tuple[complex, float, int]], climb: float, *, sided: bool) -> Robot:
    """Return the corresponding robot with cylinders along z."""
    surfaces = [
        WrapSurface(f"c{k}", WORLD, "cylinder", R, Pose((c.real, c.imag, 0.3)))
        for k, (c, R, _) in enumerate(circles)
    ]
    wraps = tuple(
        Wrap(f"c{k}", 0, (s if sided else 0))  # type: ignore[arg-type]
        for k, (_, _, s) in enumerate(circles)
    )
    ends = (ViaPoint(WORLD, (-1.0, 0.0, 0.0)), ViaPoint(FAR, (1.0, 0.05, climb)))
    return carriage([Muscle("m", ends, wraps=wraps)], surfaces)


@pytest.mark.parametrize("senses", [*product((1, -1), repeat=2), (1, -1, 1), (-1, 1, 1)])
@pytest.mark.parametrize("climb", [0.0, 0.4])
def test_parallel_cylinders_with_specified_sides(senses: tuple[int, ...], climb: float) -> None:
    """Each cylinder intersects the straight line."""
    places = np.linspace(-0.6, 0.6, len(senses))
    circles = [
        (complex(x, 0.01 * (-1) ** k), 0.15, s)
        for k, (x, s) in enumerate(zip(places, senses, strict=True))
    ]
    robot = parallel(circles, climb, sided=True)
    (length,) = MusclePaths(robot).evaluate(np.zeros(3)).lengths
    expected = belt(circles, -1.0 + 0j, 1.0 + 0.05j, climb)
    assert length == pytest.approx(expected, abs=1e-12)


def test_path_without_sides_is_the_shortest() -> None:
    places = [(-0.5 + 0.02j, 0.2), (0.0 - 0.03j, 0.2), (0.5 + 0.01j, 0.2)]
    lengths = [
        MusclePaths(
            parallel([(c, R, s) for (c, R), s in zip(places, senses, strict=True)], 0.2, sided=True)
        )
        .evaluate(np.zeros(3))
        .lengths[0]
        for senses in product((1, -1), repeat=3)
    ]
    free = parallel([(c, R, 1) for c, R in places], 0.2, sided=False)
    (length,) = MusclePaths(free).evaluate(np.zeros(3)).lengths
    assert length == pytest.approx(min(lengths), abs=1e-12)


def over_sphere(a: np.ndarray, b: np.ndarray, c: np.ndarray, R: float) -> float:
    """Return the length of the shorter path from a to b over a sphere, with both outside."""
    a, b = a - c, b - c
    if min(a @ a, b @ b) < R**2:
        return 1e3
    d = b - a
    t = min(1.0, max(0.0, -(a @ d) / (d @ d)))
    if np.linalg.norm(a + t * d) >= R:
        return float(np.linalg.norm(d))
    ra, rb = np.linalg.norm(a), np.linalg.norm(b)
    turn = math.atan2(np.linalg.norm(np.cross(a, b)), a @ b)
    arc = turn - math.acos(R / ra) - math.acos(R / rb)
    return math.sqrt(ra**2 - R**2) + math.sqrt(rb**2 - R**2) + R * max(0.0, arc)


@pytest.mark.slow
def test_path_over_two_spheres_is_taut_and_near_the_shortest() -> None:
    """Compare with a search for the point between both spheres from many starts."""
    rng = np.random.default_rng(11)
    robot = sequences(rng, 30, 2, shapes=("sphere",))
    lengths = MusclePaths(robot).evaluate(np.zeros(3)).lengths
    shortest = 0
    for k, muscle in enumerate(robot.muscles):
        first, second = robot.wrap_surfaces[2 * k : 2 * k + 2]
        start, end = (np.array(point.position) for point in muscle.via_points)
        c, d = np.array(first.pose.position), np.array(second.pose.position)

        def length(x, start=start, end=end, c=c, d=d, R=first.radius, r=second.radius):
            return over_sphere(start, x, c, R) + over_sphere(x, end, d, r)

        tries = [
            minimize(
                length,
                0.5 * (c + d) + 0.1 * rng.normal(size=3),
                method="BFGS",
                options={"gtol": 1e-9},
            )
            for _ in range(12)
        ]
        taut = np.array([one.fun for one in tries])
        assert abs(taut - lengths[k]).min() < 1e-9
        assert lengths[k] <= taut.min() * 1.01
        shortest += lengths[k] <= taut.min() + 1e-9
    assert shortest >= 20


@pytest.mark.cases(10)
@pytest.mark.parametrize("count", sample_cases([2, 3, 5], 2))
@pytest.mark.parametrize("options", KINDS, ids=NAMES)
def test_jacobian_is_the_derivative_of_the_lengths(options: dict[str, object], count: int) -> None:
    rng = np.random.default_rng(12)
    robot = sequences(rng, 60, count, **options)  # type: ignore[arg-type]
    paths = MusclePaths(robot)
    compared = 0
    for _ in range(5):
        q = rng.uniform(-0.1, 0.1, 3)
        compared += check_jacobian(paths, q, STEP, 1e-3)
    assert compared >= 0.99 * 60 * 5 * 3


@pytest.mark.cases(4)
@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3, 5])
@pytest.mark.parametrize("options", KINDS, ids=NAMES)
def test_cable_is_straight_between_surfaces(options: dict[str, object], count: int) -> None:
    """The directions at both ends of each straight part agree."""
    rng = np.random.default_rng(13)
    muscles, bad = 200, 0
    robot = sequences(rng, muscles, count, **options)  # type: ignore[arg-type]
    paths = MusclePaths(robot)
    for _ in range(5):
        pulls = paths.point_forces(rng.uniform(-0.1, 0.1, 3), np.ones(muscles))
        total = np.zeros((muscles, 3))
        np.add.at(total, pulls.muscles, pulls.forces)
        bad += int((abs(total).max(axis=1) > 1e-10).sum())
    assert bad == 0


@pytest.mark.slow
def test_length_is_continuous_along_a_motion() -> None:
    """Without specified sides, the length changes by at most the displacement."""
    rng = np.random.default_rng(14)
    robot = sequences(rng, 40, 2, shapes=("cylinder",))
    paths = MusclePaths(robot)
    for _ in range(5):
        begin, end = rng.uniform(-0.2, 0.2, (2, 3))
        step = np.linalg.norm(end - begin) / 400
        lengths = np.array(
            [
                paths.evaluate(begin + t * (end - begin)).lengths.copy()
                for t in np.linspace(0, 1, 401)
            ]
        )
        assert abs(np.diff(lengths, axis=0)).max() <= step + 1e-9


def test_surface_without_contact_does_not_change_the_length() -> None:
    """If one surface has no contact, the length is determined by the other."""
    circle = (0.0 + 0.0j, 0.2, 1)
    far = (0.5 - 3.0j, 0.2, 1)
    both = parallel([circle, far], 0.1, sided=False)
    alone = parallel([circle], 0.1, sided=False)
    expected = MusclePaths(alone).evaluate(np.zeros(3)).lengths
    np.testing.assert_allclose(
        MusclePaths(both).evaluate(np.zeros(3)).lengths, expected, atol=1e-12
    )


def test_overlapping_surfaces_have_finite_lengths() -> None:
    circles = [(-0.05 + 0j, 0.2, 1), (0.05 + 0.05j, 0.2, 1)]
    for sided in (False, True):
        state = MusclePaths(parallel(circles, 0.1, sided=sided)).evaluate(np.zeros(3))
        assert np.isfinite(state.lengths).all()
        assert np.isfinite(state.jacobian).all()
        assert 2.0 < state.lengths[0] < 4.0
