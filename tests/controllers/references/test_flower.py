from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.cases import sample_cases

from addin_sdfusion.robot import InputError
from controllers import ApproachReference, FlowerReference, Reference, SequenceReference

CENTRE = np.array([0.45, -0.45, 0.45])
X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def flower(petals: int = 5, duration: float = 30.0) -> FlowerReference:
    return FlowerReference(CENTRE, [X, Z], 0.15, duration, petals)


def assert_rates_are_derivatives(reference: Reference, t: float, h: float) -> None:
    before, here, after = (reference.evaluate(t + s) for s in (-h, 0.0, h))
    scale = 1.0 / reference.duration
    np.testing.assert_allclose(here.qd, (after.q - before.q) / (2 * h), atol=1e-6 * scale)
    np.testing.assert_allclose(here.qdd, (after.qd - before.qd) / (2 * h), atol=1e-5 * scale**2)


@given(st.integers(1, 7), st.floats(0.01, 0.99), st.sampled_from([0.5, 30.0]))
def test_rates_are_derivatives_of_positions(petals: int, part: float, duration: float) -> None:
    assert_rates_are_derivatives(flower(petals, duration), part * duration, 1e-6 * duration)


def quintic(u: np.ndarray) -> np.ndarray:
    return np.where(u < 0, 0, np.where(u > 1, 1, 10 * u**3 - 15 * u**4 + 6 * u**5))


@given(st.integers(1, 7), st.floats(-math.pi, math.pi))
def test_flower_matches_the_formula_of_the_rose(petals: int, turn: float) -> None:
    """Compare one call for all times with y = c + R cos(k phi) (cos(phi) e1 + sin(phi) e2)."""
    e1, e2 = np.array([math.cos(turn), 0.0, math.sin(turn)]), np.array([0.0, 1.0, 0.0])
    times = np.linspace(-5.0, 35.0, 81)
    phi = (math.pi if petals % 2 else 2 * math.pi) * quintic(times / 30.0)[:, None]
    expected = CENTRE + 0.15 * np.cos(petals * phi) * (np.cos(phi) * e1 + np.sin(phi) * e2)
    found = FlowerReference(CENTRE, [e1, e2], 0.15, 30.0, petals).evaluate(times)
    np.testing.assert_allclose(found.q, expected, atol=1e-14)


@pytest.mark.cases(3)
@pytest.mark.slow
@pytest.mark.parametrize("petals", sample_cases(range(1, 8), 3))
def test_curve_is_closed_and_traverses_every_petal_once(petals: int) -> None:
    curve = flower(petals)
    points = curve.evaluate(np.linspace(0.0, 30.0, 20001)).q
    np.testing.assert_allclose(points[0], CENTRE + 0.15 * X, atol=1e-15)
    np.testing.assert_allclose(points[-1], points[0], atol=1e-12)
    x, z = (points[:-1] - CENTRE)[:, [0, 2]].T
    at_tip = np.hypot(x, z) > 0.149
    visits = np.count_nonzero(at_tip & ~np.roll(at_tip, 1))
    tips = np.round(np.arctan2(z, x)[at_tip] * petals / math.pi).astype(int) % (2 * petals)
    assert visits == len(set(tips)) == (petals if petals % 2 else 2 * petals)


@given(st.floats(-10.0, 0.0), st.integers(1, 7))
def test_flower_is_at_rest_before_and_after(early: float, petals: int) -> None:
    for t in (early, 30.0 - early):
        y, yd, ydd = flower(petals).evaluate(t)
        np.testing.assert_allclose(y, CENTRE + 0.15 * X, atol=1e-12)
        assert not yd.any()
        assert not ydd.any()


def test_flower_starts_and_stops_smoothly() -> None:
    for t in (1e-6, 30.0 - 1e-6):
        _, yd, ydd = flower().evaluate(t)
        assert np.abs(yd).max() < 1e-9
        assert np.abs(ydd).max() < 1e-6


def test_approach_is_straight_with_minimum_jerk() -> None:
    way, times = ApproachReference([0.0, 1.0], [1.0, 3.0], 2.0), np.linspace(-1.0, 3.0, 41)
    expected = [0.0, 1.0] + quintic(times / 2.0)[:, None] * [1.0, 2.0]
    np.testing.assert_allclose(way.evaluate(times).q, expected, atol=1e-14)
    np.testing.assert_array_equal(way.evaluate(9.0).q, [1.0, 3.0])
    for t in np.linspace(0.05, 1.95, 20):
        assert_rates_are_derivatives(way, t, 1e-6)


def test_sequence_evaluates_its_parts_in_order() -> None:
    start = np.array([0.711, -0.398, 0.129])
    way, curve = ApproachReference(start, CENTRE + 0.15 * X, 3.0), flower()
    both = SequenceReference([way, curve])
    assert both.duration == 33.0
    assert both.name == "approach, flower"
    np.testing.assert_array_equal(both.evaluate(-1.0).q, start)
    for t in (0.5, 2.9):
        np.testing.assert_array_equal(both.evaluate(t), way.evaluate(t))
    for t in (3.0, 3.5, 20.0, 40.0):
        np.testing.assert_array_equal(both.evaluate(t), curve.evaluate(t - 3.0))
    times = np.linspace(2.9, 3.1, 2001)
    path = np.array(both.evaluate(times))
    assert np.abs(np.diff(path, axis=1)).max() < 1e-4  # positions, velocities, accelerations


def test_array_of_times_matches_single_times() -> None:
    curve = SequenceReference([ApproachReference(X, CENTRE + 0.15 * X, 3.0), flower()])
    times = np.linspace(-1.0, 40.0, 83)
    for kind in (curve, pickle.loads(pickle.dumps(curve))):
        rows = kind.evaluate(times)
        single = [curve.evaluate(t) for t in times.tolist()]
        np.testing.assert_array_equal(np.stack(rows, axis=1), single)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: FlowerReference(CENTRE, [X, 2 * Z], 0.1, 1.0), "orthonormal"),
        (lambda: FlowerReference(CENTRE, [X, X], 0.1, 1.0), "orthonormal"),
        (lambda: FlowerReference(CENTRE, [X[:2], Z[:2]], 0.1, 1.0), "axes"),
        (lambda: FlowerReference([np.nan, 0.0, 0.0], [X, Z], 0.1, 1.0), "centre"),
        (lambda: FlowerReference(CENTRE, [X, Z], 0.0, 1.0), "radius"),
        (lambda: FlowerReference(CENTRE, [X, Z], 0.1, math.inf), "duration"),
        (lambda: FlowerReference(CENTRE, [X, Z], 0.1, 1.0, 0), "petals"),
        (lambda: FlowerReference(CENTRE, [X, Z], 0.1, 1.0, 2.5), "petals"),  # type: ignore[arg-type]
        (lambda: ApproachReference([0.0], [0.0, 1.0], 1.0), "equal lengths"),
        (lambda: ApproachReference([0.0], [1.0], -1.0), "duration"),
        (lambda: ApproachReference([0.0], [1.0], 1e-200), "duration must be between"),
        (lambda: FlowerReference(CENTRE, [X, Z], 0.1, 1e200), "duration must be between"),
        (lambda: SequenceReference([]), "at least one"),
        (lambda: SequenceReference([flower(), ApproachReference(X, Z, 1.0)]), "part 1 .* ends at"),
        (lambda: SequenceReference([flower(), ApproachReference([0.0], [1.0], 1.0)]), "part 1"),
    ],
)
def test_wrong_references_raise_an_error(make, named: str) -> None:
    with pytest.raises(InputError, match=named):
        make()
