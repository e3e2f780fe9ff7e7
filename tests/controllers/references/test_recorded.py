from __future__ import annotations

import math
import subprocess
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addin_sdfusion.robot import InputError
from controllers import SplineReference, recorded_trajectory, waypoint_trajectory
from controllers.references import smoothing


def motion(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return two coordinates with their exact derivatives."""
    q = np.stack([np.sin(1.3 * t) + 0.2 * np.cos(5 * t), 0.3 * np.sin(1.6 * t)], 1)
    qd = np.stack([1.3 * np.cos(1.3 * t) - np.sin(5 * t), 0.48 * np.cos(1.6 * t)], 1)
    qdd = np.stack([-1.69 * np.sin(1.3 * t) - 5 * np.cos(5 * t), -0.768 * np.sin(1.6 * t)], 1)
    return q, qd, qdd


def jerk_integral(reference: SplineReference) -> float:
    """Integrate the squared third derivative exactly by Gauss quadrature in each segment."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    total = 0.0
    for k, (begin, end) in enumerate(zip(reference.times[:-1], reference.times[1:], strict=True)):
        c = reference.coefficients[k, :, 2]  # coefficients of the accelerations
        t = (nodes + 1.0) / 2.0 * (end - begin)
        jerk = sum(p * np.outer(t ** (p - 1), c[p]) for p in range(1, len(c)))
        total += float(weights @ np.sum(jerk**2, axis=1)) * (end - begin) / 2.0
    return total


@given(
    st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), min_size=2, max_size=7),
    st.lists(st.floats(0.3, 2.0), min_size=6, max_size=6),
    st.integers(0, 2**31),
)
def test_waypoint_trajectory_has_minimum_jerk(
    points: list[tuple[float, float]], steps: list[float], seed: int
) -> None:
    """Other splines through the same points have more jerk, and qdd is smooth."""
    times = np.concatenate([[0.0], np.cumsum(steps[: len(points) - 1])])
    q = np.array(points)
    trajectory = waypoint_trajectory(times, q)
    reference = SplineReference(trajectory)
    found = reference.evaluate(times)
    np.testing.assert_allclose(found[0], q, atol=1e-9)
    np.testing.assert_allclose(found[1][[0, -1]], 0.0, atol=1e-8)
    np.testing.assert_allclose(found[2][[0, -1]], 0.0, atol=1e-7)
    for t in times[1:-1]:
        before, after = (reference.evaluate(t + side) for side in (-1e-9, 1e-9))
        np.testing.assert_allclose(before.qdd, after.qdd, atol=1e-5 * (1 + abs(after.qdd).max()))
    least, rng = jerk_integral(reference), np.random.default_rng(seed)
    for _ in range(3):
        qd, qdd = (np.array([getattr(p, n) for p in trajectory.points]) for n in ("qd", "qdd"))
        qd[1:-1] += rng.normal(size=qd[1:-1].shape)
        qdd[1:-1] += rng.normal(size=qdd[1:-1].shape)
        changed = tuple(
            type(p)(p.time, p.q, tuple(v), tuple(a))
            for p, v, a in zip(trajectory.points, qd, qdd, strict=True)
        )
        other = SplineReference(type(trajectory)("other", "quintic", changed, 1.0))
        assert jerk_integral(other) >= least * (1.0 - 1e-9)


def test_two_waypoints_match_the_textbook_minimum_jerk_motion() -> None:
    reference = SplineReference(waypoint_trajectory(np.array([0.0, 2.0]), np.array([[0.0], [1.0]])))
    s = np.linspace(0.0, 1.0, 21)
    q, qd, qdd = reference.evaluate(2.0 * s)
    np.testing.assert_allclose(q[:, 0], 10 * s**3 - 15 * s**4 + 6 * s**5, atol=1e-12)
    np.testing.assert_allclose(qd[:, 0], (30 * s**2 - 60 * s**3 + 30 * s**4) / 2, atol=1e-12)
    np.testing.assert_allclose(qdd[:, 0], (60 * s - 180 * s**2 + 120 * s**3) / 4, atol=1e-12)


@pytest.mark.parametrize("noise", [1e-5, 1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("rate", [50, 200])
def test_noisy_positions_yield_velocities_and_accelerations(rate: int, noise: float) -> None:
    """Finite differences would have errors of 0.7 noise * rate and 2.4 noise * rate²."""
    t = np.arange(0.0, 8.0, 1.0 / rate)
    exact = motion(t)
    q = exact[0] + noise * np.random.default_rng(3).normal(size=exact[0].shape)
    found = SplineReference(recorded_trajectory(t, q)).evaluate(t)
    inner = slice(len(t) // 10, -len(t) // 10)
    errors = [np.sqrt(np.mean((a - b)[inner] ** 2)) for a, b in zip(found, exact, strict=True)]
    assert errors[0] < 0.8 * noise
    assert errors[1] < 0.2 * noise * rate
    assert errors[2] < 0.05 * noise * rate**2


@pytest.mark.parametrize(("rate", "bounds"), [(10, (1e-9, 1e-3)), (100, (1e-8, 1e-4))])
def test_exact_positions_are_not_smoothed(rate: int, bounds: tuple[float, float]) -> None:
    t = np.arange(0.0, 8.0, 1.0 / rate)
    exact = motion(t)
    found = SplineReference(recorded_trajectory(t, exact[0])).evaluate(t)
    inner = slice(len(t) // 10, -len(t) // 10)
    np.testing.assert_allclose(found[0], exact[0], atol=bounds[0])
    np.testing.assert_allclose(found[2][inner], exact[2][inner], atol=bounds[1])
    through = recorded_trajectory(t, exact[0], noise=0.0)
    np.testing.assert_allclose([p.q for p in through.points], exact[0], atol=1e-12)


def test_uneven_sampling_is_supported() -> None:
    rng = np.random.default_rng(5)
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(0.005, 0.02, 600))])
    exact = motion(t)
    q = exact[0] + 1e-4 * rng.normal(size=exact[0].shape)
    found = SplineReference(recorded_trajectory(t, q, noise=1e-4)).evaluate(t)
    assert np.sqrt(np.mean((found[2] - exact[2])[60:-60] ** 2)) < 0.05


def test_given_velocities_are_used() -> None:
    t = np.linspace(0.0, 2.0, 101)
    q, qd, qdd = motion(t)
    given_all = recorded_trajectory(t, q, qd, qdd)
    assert given_all.spline == "samples"
    assert [p.qdd for p in given_all.points] == [tuple(row) for row in qdd]
    derived = recorded_trajectory(t, q, qd)
    assert [p.qd for p in derived.points] == [tuple(row) for row in qd]
    accelerations = np.array([p.qdd for p in derived.points])
    np.testing.assert_allclose(accelerations[10:-10], qdd[10:-10], atol=1e-4)


@pytest.mark.parametrize(
    ("times", "q", "message"),
    [
        ([0.0, 0.1, 0.1, 0.2, 0.3, 0.4], np.zeros((6, 1)), "time in row 3 that is not after"),
        ([1.0, 1.1, 1.2, 1.3, 1.4, 1.5], np.zeros((6, 1)), "begins at 1 s"),
        ([0.0, 0.1, 0.2], np.zeros((3, 1)), "at least 6 rows"),
        ([0.0, 0.1, 0.2], np.zeros((2, 1)), "for 3 times"),
        ([0.0, 0.1, 0.2, 0.3, 0.4, 0.5], np.full((6, 1), np.nan), "not finite"),
    ],
)
def test_invalid_motion_raises_an_error(times: list[float], q: np.ndarray, message: str) -> None:
    with pytest.raises(InputError, match=message):
        recorded_trajectory(np.array(times), q)


def test_recording_without_motion_has_zero_velocity() -> None:
    t = np.linspace(0.0, 1.0, 50)
    found = SplineReference(recorded_trajectory(t, np.full((50, 1), 0.3))).evaluate(t)
    np.testing.assert_allclose(found[0], 0.3)
    np.testing.assert_allclose(found[2], 0.0, atol=1e-6)


@pytest.mark.parametrize("make", [waypoint_trajectory, partial(recorded_trajectory, noise=0.0)])
def test_too_uneven_times_raise_an_error(make) -> None:
    times = np.array([0.0, 1e-320, 2e-320, 1.0, 1.5, 2.0, 2.5, 3.0])
    with pytest.raises(InputError, match="too uneven"):
        make(times, np.sin(np.arange(8.0))[:, None])


@pytest.mark.parametrize("noise", [math.nan, 1e308, -1.0])
def test_invalid_noise_raises_an_error(noise: float) -> None:
    times = np.linspace(0.0, 1.0, 11)
    with pytest.raises(InputError, match="noise must be between 0 and"):
        recorded_trajectory(times, np.sin(times)[:, None], noise=noise)


def noisy(count: int) -> tuple[np.ndarray, np.ndarray]:
    times = np.arange(count) * 1e-3
    return times, np.sin(times) + 1e-3 * np.random.default_rng(1).standard_normal(count)


def test_long_recording_is_smoothed_as_a_short_one_in_a_separate_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The process executes no Python files of the current folder."""
    (tmp_path / "numpy.py").write_text("raise SystemExit(7)")
    monkeypatch.chdir(tmp_path)
    times, q = noisy(smoothing._MAX_DIRECT + 1)
    residual = 1e-6 * len(times)
    separate = smoothing.smoothing_spline(times, q, residual)
    monkeypatch.setattr(smoothing, "_MAX_DIRECT", len(times))
    for found, expected in zip(
        separate, smoothing.smoothing_spline(times, q, residual), strict=True
    ):
        np.testing.assert_array_equal(found, expected)


def test_recording_that_takes_too_long_to_smooth_is_rejected(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ended = subprocess.CompletedProcess([], smoothing._OUT_OF_TIME)
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: ended)
    with pytest.raises(InputError, match="requires more than 20 s to smooth 5001 rows; use fewer"):
        smoothing.smoothing_spline(*noisy(5001), 1.0)
