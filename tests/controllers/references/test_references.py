from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.interpolate import BPoly, PPoly
from support.robots.robots import PLANAR_2R

from addin_sdfusion.robot import InputError, Trajectory, TrajectoryPoint
from addin_sdfusion.robot.formats.read import read_trajectory
from controllers import SplineReference

numbers = st.floats(-3.0, 3.0)
pairs = st.tuples(numbers, numbers)


def trajectory(spline: str, rows: list[tuple], steps: list[float]) -> Trajectory:
    times = np.concatenate([[0.0], np.cumsum(steps[: len(rows) - 1])])
    used = {"linear": 1, "cubic": 2, "quintic": 3}[spline]
    points = [TrajectoryPoint(float(t), *row[:used]) for t, row in zip(times, rows, strict=True)]
    return Trajectory("random", spline, tuple(points), 0.01)  # type: ignore[arg-type]


trajectories = st.builds(
    trajectory,
    st.sampled_from(["linear", "cubic", "quintic"]),
    st.lists(st.tuples(pairs, pairs, pairs), min_size=2, max_size=4),
    st.lists(st.floats(0.1, 5.0), min_size=3, max_size=3),
)


@given(trajectories)
def test_spline_passes_through_its_points(given_points: Trajectory) -> None:
    """A cubic also matches velocities, and a quintic also matches accelerations."""
    reference = SplineReference(given_points)
    for k, point in enumerate(given_points.points):
        given = [row for row in (point.q, point.qd, point.qdd) if row]
        for side in (1e-12, -1e-12):  # both adjacent polynomials
            if (k == 0 and side < 0) or (k == len(given_points.points) - 1 and side > 0):
                continue
            rows = reference.evaluate(max(0.0, min(point.time + side, reference.duration)))
            for row, expected in zip(rows, given, strict=False):
                np.testing.assert_allclose(row, expected, atol=1e-6)


@given(trajectories, st.floats(0.02, 0.98))
def test_rates_are_derivatives_of_positions(given_points: Trajectory, part: float) -> None:
    reference, h = SplineReference(given_points), 1e-5
    first, second = given_points.points[:2]
    t = first.time + part * (second.time - first.time)
    before, here, after = (reference.evaluate(t + s) for s in (-h, 0.0, h))
    np.testing.assert_allclose(here.qd, (after.q - before.q) / (2 * h), atol=1e-4)
    np.testing.assert_allclose(here.qdd, (after.qd - before.qd) / (2 * h), rtol=1e-4, atol=1e-2)


def test_motion_of_the_paper_is_the_minimum_jerk_quintic() -> None:
    """The motion is q = -0.5 + 10 s^3 - 15 s^4 + 6 s^5 over 4 s, and back."""
    motion = read_trajectory(PLANAR_2R / "robot/planar_2r_trajectories.xml", "simple_joint_motion")
    reference = SplineReference(motion)
    assert reference.duration == 8.0
    t = np.linspace(0.0, 8.0, 81)
    s = np.minimum(t / 4.0, 2.0 - t / 4.0)
    q1 = -0.5 + 10 * s**3 - 15 * s**4 + 6 * s**5
    np.testing.assert_allclose(reference.evaluate(t).q, np.stack([q1, -q1], 1), atol=1e-13)
    middle = reference.evaluate(2.0)
    assert middle.qd[0] == pytest.approx(1.875 / 4.0)


def caspr_blend(q0: float, q1: float, duration: float, blend: float, t: float) -> list[float]:
    """Return position, velocity and acceleration of the parabolic blend of CASPR."""
    a = (q0 - q1) / (blend**2 - duration * blend)
    corner = q0 + a * blend**2 / 2
    v = ((q0 + q1) / 2 - corner) / (duration / 2 - blend)
    if t < blend:
        return [q0 + a * t**2 / 2, a * t, a]
    if t < duration - blend:
        return [corner + v * (t - blend), v, 0.0]
    return [q1 - a * (t - duration) ** 2 / 2, -a * (t - duration), -a]


@given(numbers, numbers, st.floats(0.1, 5.0), st.floats(0.05, 0.49), st.floats(0.0, 0.999))
def test_parabolic_blend_matches_caspr(
    q0: float, q1: float, duration: float, share: float, part: float
) -> None:
    blend, t = share * duration, part * duration
    assume(min(t, abs(t - blend), abs(t - duration + blend)) > 1e-9)  # not at a step of qdd
    points = (
        TrajectoryPoint(0.0, (1.0,)),
        TrajectoryPoint(1.0, (q0,), blend_time=0.2),
        TrajectoryPoint(1.0 + duration, (q1,), blend_time=blend),
    )
    reference = SplineReference(Trajectory("blend", "parabolic_blend", points, 0.01))
    point = np.array(reference.evaluate(1.0 + t)).ravel()
    expected = caspr_blend(q0, q1, duration, blend, t)
    np.testing.assert_allclose(point, expected, atol=1e-10 * (1.0 + abs(expected[2])))


def test_published_blend_stops_at_points_and_is_straight_between(shared: Path) -> None:
    file = shared / "robots/caspr/Example_planar_XY/Example_planar_XY_trajectories.xml"
    reference = SplineReference(read_trajectory(file, "example_parabolic_blend"))
    for t, q in ((0.0, (0.3, 0.5, 0.0)), (5.0, (0.7, 0.5, 0.0)), (10.0, (0.4, 0.3, 0.1))):
        np.testing.assert_allclose(reference.evaluate(t).q, q, atol=1e-14)
        np.testing.assert_allclose(reference.evaluate(t).qd, 0.0, atol=1e-14)
    np.testing.assert_allclose(reference.evaluate(2.5).qd, [0.4 / 4.5, 0.0, 0.0], atol=1e-14)
    np.testing.assert_allclose(reference.evaluate(9.0).qdd, np.array([3, 2, -1]) / 52.5, atol=1e-13)


def test_average_velocities_yield_a_smooth_cubic(shared: Path) -> None:
    """The velocity at the inner point is the mean slope, ((0.05, -0.1) + (0.1, 0.2/3)) / 2."""
    file = shared / "robots/caspr/Example_planar_XY/Example_planar_XY_trajectories.xml"
    reference = SplineReference(read_trajectory(file, "example_cubic_average_velocity"))
    for t in (2.0 - 1e-9, 2.0 + 1e-9):
        point = reference.evaluate(t)
        np.testing.assert_allclose(point.q, [0.4, 0.3, 0.0], atol=1e-8)
        np.testing.assert_allclose(point.qd, [0.075, -1 / 60, 0.0], atol=1e-8)


def test_samples_are_interpolated_linearly(shared: Path) -> None:
    file = shared / "robots/caspr/Example_planar_XY/Example_planar_XY_trajectories.xml"
    trajectory = read_trajectory(file, "example_file")
    reference = SplineReference(trajectory)
    assert (trajectory.time_step, reference.duration) == (0.01, 4.0)
    for before, after in pairwise(trajectory.points):
        point = reference.evaluate(before.time)
        for row, given_row in zip(point, (before.q, before.qd, before.qdd), strict=True):
            np.testing.assert_allclose(row, given_row, atol=1e-12)
        middle = reference.evaluate((before.time + after.time) / 2)
        mean = (np.array(before.qdd) + np.array(after.qdd)) / 2
        np.testing.assert_allclose(middle.qdd, mean, atol=1e-12)


def test_operational_trajectory_returns_y(shared: Path) -> None:
    file = shared / "robots/caspr/RoboyLeftArm/RoboyLeftArm_trajectories.xml"
    reference = SplineReference(read_trajectory(file, "xylo_1", "operational"))
    assert reference.duration == 80.0
    np.testing.assert_allclose(reference.evaluate(4.0).q, [0.65, -0.45, 0.35], atol=1e-14)


@given(trajectories)
def test_reference_is_at_rest_outside_its_duration(given_points: Trajectory) -> None:
    reference = SplineReference(given_points)
    for t, point in ((-1.0, given_points.points[0]), (1e3, given_points.points[-1])):
        q, qd, qdd = reference.evaluate(t)
        assert tuple(q) == point.q
        assert not qd.any()
        assert not qdd.any()


@given(st.data(), st.integers(1, 3), st.integers(2, 5))
def test_polynomials_equal_piecewise_polynomials_of_scipy(
    data: st.DataObject, n: int, count: int
) -> None:
    """Check coefficients, also for points with different numbers of derivatives."""
    row = st.tuples(*[numbers] * n)
    rows = st.one_of(st.tuples(row), st.tuples(row, row), st.tuples(row, row, row))
    given_rows = data.draw(st.lists(rows, min_size=count, max_size=count))
    times = np.cumsum(data.draw(st.lists(st.floats(0.1, 5.0), min_size=count, max_size=count)))
    points = [TrajectoryPoint(float(t), *r) for t, r in zip(times, given_rows, strict=True)]
    reference = SplineReference(Trajectory("random", "quintic", tuple(points), 0.01))
    piecewise = PPoly.from_bernstein_basis(BPoly.from_derivatives(times.tolist(), given_rows))
    for order in range(3):
        derivative = piecewise.derivative(order).c[::-1].transpose(1, 0, 2)
        found = reference.coefficients[:, : derivative.shape[1], order]
        scale = max(1.0, np.abs(derivative).max())
        np.testing.assert_allclose(found, derivative, rtol=0.0, atol=1e-12 * scale)
        inside = np.linspace(times[0], times[-1], 50)[1:-1]
        expected = piecewise.derivative(order)(inside)
        tolerance = 1e-12 * max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(reference.evaluate(inside)[order], expected, atol=tolerance)


@pytest.mark.parametrize("spline", ["linear", "cubic", "quintic", "samples", "parabolic_blend"])
def test_points_too_far_apart_raise_an_error(spline: Any) -> None:
    rest = (0.0, 0.0)
    points = (
        TrajectoryPoint(0.0, rest, rest, rest),
        TrajectoryPoint(1.0, rest, rest, rest, 0.5),
        TrajectoryPoint(1.0 + 1e-9, (1e304, 0.0), rest, rest, 1e-10),
    )
    with pytest.raises(InputError, match="'far' is too fast after 1 s: the points are"):
        SplineReference(Trajectory("far", spline, points, 0.01))
