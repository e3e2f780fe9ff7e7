from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robots import PLANAR_2R

from addin_sdfusion.robot import Trajectory, TrajectoryPoint
from addin_sdfusion.robot.readers import read_trajectory
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
def test_the_spline_passes_through_its_points(given_points: Trajectory) -> None:
    """Positions; velocities too for a cubic; accelerations too for a quintic."""
    reference = SplineReference(given_points)
    for k, point in enumerate(given_points.points):
        wanted = [row for row in (point.q, point.qd, point.qdd) if row]
        for side in (1e-12, -1e-12):  # both polynomials that meet there
            if (k == 0 and side < 0) or (k == len(given_points.points) - 1 and side > 0):
                continue
            rows = reference.evaluate(max(0.0, min(point.time + side, reference.duration)))
            for row, expected in zip(rows, wanted, strict=False):
                np.testing.assert_allclose(row, expected, atol=1e-6)


@given(trajectories, st.floats(0.02, 0.98))
def test_rates_are_the_derivatives_of_the_positions(given_points: Trajectory, part: float) -> None:
    reference, h = SplineReference(given_points), 1e-5
    first, second = given_points.points[:2]
    t = first.time + part * (second.time - first.time)
    before, here, after = (reference.evaluate(t + s) for s in (-h, 0.0, h))
    np.testing.assert_allclose(here.qd, (after.q - before.q) / (2 * h), atol=1e-4)
    np.testing.assert_allclose(here.qdd, (after.qd - before.qd) / (2 * h), rtol=1e-4, atol=1e-2)


def test_the_papers_motion_is_the_quintic_of_minimum_jerk() -> None:
    """It is q = -0.5 + 10 s^3 - 15 s^4 + 6 s^5 over 4 s, and back."""
    motion = read_trajectory(PLANAR_2R / "robot/planar_2r_trajectories.xml", "simple_joint_motion")
    reference = SplineReference(motion)
    assert reference.duration == 8.0
    for t in np.linspace(0.0, 8.0, 81):
        s = t / 4.0 if t <= 4.0 else 2.0 - t / 4.0
        q1 = -0.5 + 10 * s**3 - 15 * s**4 + 6 * s**5
        point = reference.evaluate(float(t))
        np.testing.assert_allclose(point.q, [q1, -q1], atol=1e-13)
    middle = reference.evaluate(2.0)
    assert middle.qd[0] == pytest.approx(1.875 / 4.0)


@given(trajectories)
def test_beyond_its_ends_the_reference_rests(given_points: Trajectory) -> None:
    reference = SplineReference(given_points)
    for t, point in ((-1.0, given_points.points[0]), (1e3, given_points.points[-1])):
        q, qd, qdd = reference.evaluate(t)
        assert tuple(q) == point.q
        assert not qd.any()
        assert not qdd.any()
