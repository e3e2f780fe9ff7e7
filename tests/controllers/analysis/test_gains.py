from __future__ import annotations

import math
import subprocess
import sys

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addin_sdfusion.robot import InputError
from controllers.analysis import gains

stiffnesses = st.floats(1.0, 1e5)
dampings = st.floats(0.1, 500.0)
delays = st.sampled_from([0, 1])


def radius(kp: float, kd: float, period: float, delay: int) -> float:
    """Compute the spectral radius of the sampled double integrator in state space."""
    A = np.array([[1.0, period], [0.0, 1.0]])
    B = np.array([[0.5 * period**2], [period]])
    K = np.array([[-kp, -kd]])
    if delay:
        A, B, K = np.block([[A, B], [K, np.zeros((1, 1))]]), np.zeros((3, 1)), np.zeros((1, 3))
    return float(np.abs(np.linalg.eigvals(A + B @ K)).max())


def test_gains_place_the_poles_of_the_continuous_loop() -> None:
    kp, kd, _ = gains.from_bandwidth(30.0, 0.7)
    poles = np.roots([1.0, kd, kp])
    np.testing.assert_allclose(np.abs(poles), 30.0)
    np.testing.assert_allclose(-poles.real / np.abs(poles), 0.7)


@pytest.mark.parametrize(("omega", "zeta"), [(0.0, 1.0), (-1.0, 1.0), (math.nan, 1.0), (1.0, 0.0)])
def test_bandwidth_must_be_positive(omega: float, zeta: float) -> None:
    with pytest.raises(InputError, match="must be positive"):
        gains.from_bandwidth(omega, zeta)


@pytest.mark.parametrize(
    ("kp", "kd", "delay", "limit_ms"),
    [(2000, 90, 0, 22.2), (2000, 90, 1, 9.49), (400, 40, 0, 50.0), (400, 40, 1, 21.3)],
)
def test_largest_stable_periods_of_published_gains(
    kp: float, kd: float, delay: int, limit_ms: float
) -> None:
    assert gains.largest_stable_period(kp, kd, delay) * 1e3 == pytest.approx(limit_ms, rel=3e-3)


@given(stiffnesses, dampings, delays, st.floats(0.01, 0.999))
def test_loop_is_stable_only_below_the_largest_stable_period(
    kp: float, kd: float, delay: int, part: float
) -> None:
    limit = gains.largest_stable_period(kp, kd, delay)
    assert radius(kp, kd, part * limit, delay) < 1.0
    assert radius(kp, kd, 1.001 * limit, delay) > 1.0


@given(stiffnesses, dampings, delays, st.floats(0.05, 1.5))
def test_poles_equal_state_space_eigenvalues(kp: float, kd: float, delay: int, part: float) -> None:
    period = part * gains.largest_stable_period(kp, kd, delay)
    largest = np.abs(gains.poles(kp, kd, period, delay)).max()
    assert largest == pytest.approx(radius(kp, kd, period, delay), rel=1e-6)


def test_coordinate_without_gains_has_no_largest_stable_period() -> None:
    assert gains.largest_stable_period(0.0, 0.0) == math.inf
    assert gains.largest_stable_period(0.0, 10.0) == pytest.approx(0.2)
    assert gains.largest_stable_period(0.0, 10.0, 1) == pytest.approx(0.1)
    assert gains.largest_stable_period(10.0, 0.0, 1) == 0.0


@pytest.mark.parametrize("delay", [0, 1])
@pytest.mark.parametrize(
    ("kp", "kd", "period"), [(2000, 90, 1e-3), (2000, 90, 5e-3), (400, 40, 5e-3)]
)
def test_margins_match_the_nyquist_curve(kp: float, kd: float, period: float, delay: int) -> None:
    """Compare margins with the curve on a fine grid, and the gain margin with the poles."""
    found = gains.margins(kp, kd, period, delay)
    w = np.geomspace(1e-2, np.pi, 200_001) / period
    z = np.exp(1j * w * period)
    a, b = 0.5 * kp * period**2, kd * period
    loop = (a * (z + 1.0) + b * (z - 1.0)) / (z - 1.0) ** 2 / z**delay
    assert found.stable
    assert found.spectral_radius == pytest.approx(radius(kp, kd, period, delay))
    assert found.modulus_margin == pytest.approx(np.abs(1.0 + loop).min(), rel=1e-6)
    crossing = np.flatnonzero(np.diff(np.sign(np.abs(loop) - 1.0)))
    assert len(crossing) == 1
    phase = np.pi + np.angle(loop[crossing[0]])
    assert found.phase_margin == pytest.approx(phase, abs=1e-3)
    assert found.delay_margin == pytest.approx(phase / w[crossing[0]], rel=1e-3)
    for factor, stable in ((0.999, True), (1.001, False)):
        scale = factor * found.gain_margin
        assert (radius(scale * kp, scale * kd, period, delay) < 1.0) is stable


def test_margins_match_python_control() -> None:
    """The numeric margins of python-control are only accurate for long periods."""
    for kp, kd, period, delay in ((2000, 90, 1e-3, 0), (2000, 90, 5e-3, 1), (400, 40, 1e-2, 1)):
        a, b = 0.5 * kp * period**2, kd * period
        loop = control.tf([a + b, a - b], [1.0, -2.0, 1.0] + delay * [0.0], period)
        _, phase, modulus = control.stability_margins(loop)[:3]
        found = gains.margins(kp, kd, period, delay)
        assert np.rad2deg(found.phase_margin) == pytest.approx(phase, rel=1e-6)
        assert found.modulus_margin == pytest.approx(modulus, rel=1e-6)


def test_margins_do_not_depend_on_the_unit_of_time() -> None:
    """Margins depend only on Kp T² and Kd T, even if all roots are close to 1."""
    slow = gains.margins(2000, 90, 1e-3, 1)
    fast = gains.margins(2000e12, 90e6, 1e-9, 1)
    assert fast.phase_margin == pytest.approx(slow.phase_margin, rel=1e-9)
    assert fast.modulus_margin == pytest.approx(slow.modulus_margin, rel=1e-9)
    assert fast.delay_margin * 1e6 == pytest.approx(slow.delay_margin, rel=1e-9)
    ideal = gains.margins(2000, 90, 1e-9)  # in the limit of continuous time
    assert 0.9 < ideal.modulus_margin <= 1.0


def test_published_delay_margins() -> None:
    assert gains.margins(2000, 90, 1e-3).delay_margin * 1e3 == pytest.approx(13.9, abs=0.05)
    assert gains.margins(2000, 90, 1e-2).delay_margin * 1e3 == pytest.approx(9.2, abs=0.05)


def test_unstable_loop_has_zero_margins() -> None:
    found = gains.margins(2000, 90, 0.01, 1)
    assert not found.stable
    assert found.spectral_radius == pytest.approx(1.0297, abs=1e-4)
    assert found.gain_margin == found.phase_margin == found.delay_margin == 0.0


def test_continuous_lqr_matches_the_closed_form() -> None:
    """Kp = sqrt(q1/r), Kd = sqrt(q2/r + 2 Kp)."""
    kp, kd, held = gains.lqr([1.0, 1e-3], 1e-6)
    assert kp == pytest.approx(1000.0)
    assert kd == pytest.approx(math.sqrt(1000.0 + 2000.0))
    assert held == 0.0
    np.testing.assert_allclose(gains.lqr([1.0, 1e-3], 1e-6, 1e-6), [kp, kd, 0.0], rtol=1e-3)


@pytest.mark.slow
@given(st.floats(1e-6, 1e2), st.floats(0.0, 1.0), st.floats(1e-3, 0.1))
def test_sampled_lqr_is_stable_for_long_periods(r: float, velocity: float, period: float) -> None:
    kp, kd, _ = gains.lqr([1.0, velocity], r, period)
    assert radius(kp, kd, period, 0) < 1.0


def test_lqr_with_delay_acts_on_the_predicted_state() -> None:
    """K = K0 [A B] compensates the delay: the poles are those without delay, and 0."""
    T = 0.01
    A, B = np.array([[1.0, T], [0.0, 1.0]]), np.array([[0.5 * T**2], [T]])
    K0 = np.array(gains.lqr(1.0, 1e-6, T)[:2])
    K = np.array(gains.lqr(1.0, 1e-6, T, delay=1))
    np.testing.assert_allclose(K, np.concatenate([K0 @ A, K0 @ B]), rtol=1e-6)
    late = np.block([[A, B], [-K[None, :2], -K[None, 2:]]])
    prompt = np.abs(np.linalg.eigvals(A - B @ K0[None]))
    found = np.sort(np.abs(np.linalg.eigvals(late)))
    np.testing.assert_allclose(found, [0.0, *np.sort(prompt)], atol=1e-6)


@pytest.mark.parametrize(
    "wrong",
    [
        {"q_weight": [0.0, 1.0]},
        {"q_weight": [1.0, -1.0]},
        {"q_weight": [1.0, 1.0, 1.0]},
        {"r_weight": 0.0},
        {"period": -1.0},
        {"period": 0.01, "delay": 2},
        {"delay": 1},
    ],
)
def test_wrong_weights_raise_an_error(wrong: dict) -> None:
    with pytest.raises(InputError, match=next(reversed(wrong))):
        gains.lqr(**{"q_weight": 1.0, "r_weight": 1.0, **wrong})


@pytest.mark.parametrize("wrong", [{"kp": -1.0}, {"kd": math.nan}, {"period": 0.0}, {"delay": 3}])
def test_wrong_loops_raise_an_error(wrong: dict) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        gains.margins(**{"kp": 1.0, "kd": 1.0, "period": 1.0, **wrong})


def test_warning_names_the_worst_coordinate_and_its_limit() -> None:
    text = gains.sampling_warning([400, 2000], [40, 90], 0.01, 1, ["elbow", "shoulder"])
    assert text is not None
    assert "'shoulder'" in text
    assert "9.49 ms" in text
    assert "\n" not in text
    assert gains.sampling_warning([400, 2000], [40, 90], 0.01, 0, ["elbow", "shoulder"]) is None
    assert gains.sampling_warning(400, 0, 0.01) is not None
    assert gains.sampling_warning([0, 400], [0, 40], 0.01) is None


@pytest.mark.slow
def test_warning_does_not_import_python_control() -> None:
    code = (
        "import sys; from controllers.analysis.gains import sampling_warning;"
        "sampling_warning(2000, 90, 0.01, 1); sys.exit('control' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
