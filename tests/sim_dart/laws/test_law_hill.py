"""Hill-type muscles: curves, force equilibrium, transients and robustness."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support.robots.muscle_bench import CURVES, HILL, Bench

from addin_sdfusion.robot.model.laws import MUSCLE_LAWS
from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native

KINDS = ("hill_degroote2016", "hill_millard2012", "hill_thelen2003")
ELASTIC = HILL | {"elastic_tendon": 1.0}
PENNATE = ELASTIC | {"pennation_at_optimal": 0.4}
UNDAMPED = {"fibre_damping": 0.0}
BENT = ("concentric", "eccentric", "passive", "tendon")


def _cases(**extra: float) -> list[tuple[str, dict[str, float]]]:
    cases = [(kind, ELASTIC | extra) for kind in KINDS]
    return [*cases, ("hill_millard2012", ELASTIC | UNDAMPED | extra)]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("curve", CURVES)
def test_slopes_are_derivatives_of_curves(kind: str, curve: Any) -> None:
    bench = Bench((kind, HILL))
    rng = np.random.default_rng(5)
    low, high = (-1.3, 1.3) if curve == "force_velocity" else (0.35, 1.9)
    if curve == "tendon_force_length":
        low, high = 1.0001, 1.1
    kinks = {"active_force_length": [], "force_velocity": [0.0, -1.0]}.get(curve, [1.0])
    x = rng.uniform(low, high, 400)
    h = 1e-6
    x = x[[min((abs(p - k) for k in kinks), default=1.0) > 2 * h for p in x]]
    centred = bench.curve(curve, x + h) - bench.curve(curve, x - h)
    np.testing.assert_allclose(
        bench.curve(curve, x, slope=True), centred / (2 * h), rtol=2e-6, atol=2e-6
    )


@pytest.mark.parametrize("kind", KINDS)
def test_curves_contain_their_anchor_points(kind: str) -> None:
    """The active force at the optimum, and passive and tendon force at their strains, are 1."""
    strains = {"tendon_strain": 0.04, "passive_fibre_strain": 0.55}
    bench = Bench((kind, HILL | strains))
    for curve, x, y in (
        ("active_force_length", 1.0, 1.0),
        ("force_velocity", 0.0, 1.0),
        ("force_velocity", -1.0, 0.0),
        ("passive_force_length", 1.55, 1.0),
        ("tendon_force_length", 1.04, 1.0),
        ("tendon_force_length", 1.0, 0.0),
    ):
        found = bench.curve(curve, x)
        assert found == pytest.approx(y, abs=1e-4 if kind == KINDS[0] and x == -1.0 else 1e-12)


ODD = [{}, {"active_shortest": 0.3, "active_transition": 0.8, "active_longest": 2.4}]
ODD += [{f"{curve}_curviness": c for curve in BENT} for c in (0.0, 0.3, 1.0)]
ODD += [{"passive_stiffness": 40.0, "tendon_stiffness": 200.0, "passive_zero_strain": -0.2}]


@pytest.mark.slow
@pytest.mark.parametrize("extra", ODD)
def test_bezier_curves_equal_de_casteljau(extra: dict[str, float]) -> None:
    """Compare with De Casteljau's algorithm to 1e-10.

    The control polygons follow from the ends of a piece, their slopes, and the curviness.
    """
    bench = Bench(("hill_millard2012", HILL | extra))
    for curve, knots, part in _pieces({**DEFAULTS, **extra}):
        x, (y, slope) = np.array(knots), (_at(bench, curve, knots, s) for s in (False, True))
        for i in range(len(knots) - 1):
            turn = slope[i] - slope[i + 1]
            corner = (y[i + 1] - y[i] - x[i + 1] * slope[i + 1] + x[i] * slope[i]) / turn
            top = (corner - x[i + 1]) * slope[i + 1] + y[i + 1]
            ends, meet = np.array([[x[i], y[i]], [x[i + 1], y[i + 1]]]), np.array([corner, top])
            near = ends + (0.1 + 0.8 * part) * (meet - ends)
            polygon = np.array([ends[0], near[0], near[0], near[1], near[1], ends[1]])
            for t in np.linspace(1e-6, 1 - 1e-6, 401):
                left = polygon
                while len(left) > 1:
                    left = left[:-1] + t * np.diff(left, axis=0)
                found = float(bench.curve(curve, left[0, 0]))
                assert found == pytest.approx(left[0, 1], abs=1e-10 * max(1.0, abs(slope).max()))


DEFAULTS = {p.name: p.default for p in MUSCLE_LAWS["hill_millard2012"].parameters}


def _pieces(p: Mapping[str, Any]) -> list[tuple[str, list[float], float]]:
    """Return the ends of the pieces of two curves by Millard et al., and their curviness."""
    begin, turn, end = (p[f"active_{name}"] for name in ("shortest", "transition", "longest"))
    active = [begin, (begin + turn) / 2, (turn + 0.95) / 2, 1.0, (1.05 + end) / 2, end]
    return [
        ("active_force_length", active, 1.0),
        ("force_velocity", [-1.0, -0.9, 0.0], p["concentric_curviness"]),
        ("force_velocity", [0.0, 0.9, 1.0], p["eccentric_curviness"]),
    ]


def _at(bench: Bench, curve: Any, x: list[float], slope: bool) -> FloatArray:
    return np.array(bench.curve(curve, np.array(x), slope=slope))


def _fibre_length_along_tendon(fibre: float, parameters: Mapping[str, float]) -> float:
    """Return the fibre length along the tendon."""
    height = parameters["optimal_fibre_length"] * math.sin(
        parameters.get("pennation_at_optimal", 0.0)
    )
    return math.sqrt(fibre**2 - height**2)


def _residual(
    bench: Bench,
    parameters: Mapping[str, float],
    damping: float,
    activation: float,
    length: float,
    fibre: float,
    w: float,
) -> float:
    """Return the fibre force along the tendon minus the tendon force, over F0."""
    along = _fibre_length_along_tendon(fibre, parameters)
    z, stretch = fibre / 0.1, (length - along) / 0.2
    speed = 0.25 + 0.75 * activation if is_thelen(bench) else 1.0
    force = (
        activation
        * float(bench.curve("active_force_length", z))
        * float(bench.curve("force_velocity", w / speed))
        + float(bench.curve("passive_force_length", z))
        + damping * w
    )
    tendon = float(bench.curve("tendon_force_length", stretch)) if stretch > 1.0 else 0.0
    return force * along / fibre - tendon


def is_thelen(bench: Bench) -> bool:
    """Return whether the law is Thelen's, whose velocity scales with activation."""
    return bench.kinds[0] == "hill_thelen2003"


def _damping(kind: str, parameters: Mapping[str, float]) -> float:
    default = {"hill_millard2012": 0.1}.get(kind, 0.0)
    return parameters.get("fibre_damping", default)


@pytest.mark.parametrize("pennation", [0.0, 0.4])
@pytest.mark.parametrize(("kind", "parameters"), _cases())
def test_muscle_at_rest_is_in_equilibrium(
    kind: str, parameters: dict[str, float], pennation: float
) -> None:
    """Compare with a root of the curves from Brent's method, to 1e-9 of F0."""
    parameters = parameters | {"pennation_at_optimal": pennation}
    bench = Bench((kind, parameters))
    for length in (0.27, 0.29, 0.3, 0.32, 0.36):
        for activation in (0.02, 0.2, 1.0):
            tension = bench.start(length, activation)
            fibre = float(bench.laws.states[1])
            args = (bench, parameters, 0.0, activation, length)
            assert abs(_residual(*args, fibre, 0.0)) < 1e-11
            shortest = max(0.0445, 0.1 * math.sin(pennation) * 1.01)
            longest = math.hypot(length - 0.2, 0.1 * math.sin(pennation))
            root = brentq(lambda z, a=args: _residual(*a, z, 0.0), shortest, longest, xtol=1e-15)
            assert fibre == pytest.approx(root, rel=1e-10)
            assert (
                np.abs(bench.state_rates(length, 0.0, activation, bench.laws.states)).max() < 1e-8
            )
            assert tension >= 0.0


@pytest.mark.parametrize("pennation", [0.0, 0.4])
@pytest.mark.parametrize(("kind", "parameters"), _cases())
def test_fibre_velocity_balances_the_forces(
    kind: str, parameters: dict[str, float], pennation: float
) -> None:
    parameters = parameters | {"pennation_at_optimal": pennation}
    bench = Bench((kind, parameters))
    damping = _damping(kind, parameters)
    for length in (0.28, 0.3, 0.33):
        for fibre in (0.07, 0.09, 0.11):
            for activation in (0.05, 0.5, 1.0):
                w = bench.state_rates(length, 0.0, 0.5, [activation, fibre])[1]
                if abs(w) > 100.0:
                    continue  # the tendon force would be many times F0
                left = _residual(bench, parameters, damping, activation, length, fibre, w)
                assert abs(left) < 1e-9 * max(1.0, abs(w))


def _moving_path(t: float) -> tuple[float, float]:
    """Return the length of an oscillating path, and its velocity."""
    return 0.3 + 0.012 * math.sin(12.0 * t), 0.144 * math.cos(12.0 * t)


def _reference(
    bench: Bench, states: FloatArray, excitation: float, end: float, times: FloatArray
) -> FloatArray:
    """Return states from an implicit Runge-Kutta method of order 5 with tight tolerances."""

    def rates(t: float, x: FloatArray) -> FloatArray:
        length, speed = _moving_path(t)
        return bench.state_rates(length, speed, excitation, x)

    found = solve_ivp(rates, (0.0, end), states, "Radau", times, rtol=1e-9, atol=1e-12)
    assert found.success
    y: FloatArray = found.y.T
    return y


def _error(bench: Bench, reference: FloatArray, excitation: float, end: float, h: float) -> float:
    """Return the largest errors of activation and normalised fibre length."""
    length, _ = _moving_path(0.0)
    bench.start(length, 0.1)
    floor = 0.0 if bench.kinds[0] == "hill_degroote2016" else 0.01
    worst = 0.0
    for k in range(round(end / h)):
        length, _ = _moving_path(k * h)
        after, _ = _moving_path((k + 1) * h)
        bench.advance(length, (after - length) / h, excitation, h)
        if (k + 1) % round(0.01 / h) == 0:
            expected = reference[round((k + 1) * h / 0.01) - 1]
            expected = np.maximum(expected, [floor, 0.0])  # the exact solution passes these bounds
            off = np.abs(bench.laws.states - expected) / np.array([1.0, 0.1])
            worst = max(worst, float(off.max()))
    return worst


@pytest.mark.cases(4)
@pytest.mark.slow
@pytest.mark.parametrize(("kind", "parameters"), _cases())
@pytest.mark.parametrize("excitation", [0.0, 0.9])
def test_transients_have_second_order(
    kind: str, parameters: dict[str, float], excitation: float
) -> None:
    """The error on a moving path is 5e-4 at 1 ms, and far less at a quarter of the step."""
    bench, end = Bench((kind, parameters)), 0.2
    bench.start(_moving_path(0.0)[0], 0.1)
    start = bench.laws.states.copy()
    times = np.arange(1, round(end / 0.01) + 1) * 0.01
    reference = _reference(bench, start, excitation, end, times)
    coarse, fine = (_error(bench, reference, excitation, end, h) for h in (1e-3, 2.5e-4))
    assert coarse < 5e-4
    assert coarse / fine > 8.0 or fine < 2e-6


@pytest.mark.parametrize("kind", KINDS)
def test_stiff_tendons_do_not_oscillate_at_any_step(kind: str) -> None:
    """A tendon with 100 times the real stiffness does not oscillate, also without activation."""
    extra = {"tendon_strain": 0.0005, "minimum_activation": 0.0, "max_contraction_velocity": 2.0}
    extra |= {} if kind == "hill_thelen2003" else {"fibre_damping": 0.0}
    bench = Bench((kind, ELASTIC | extra))
    for h in (1e-4, 1e-3, 1e-2, 1.0):
        for excitation in (0.0, 0.3, 1.0):
            expected = bench.start(0.301, excitation)
            bench.start(0.301, 1.0 - excitation)
            for _ in range(round(4.0 / h) if h >= 1e-2 else 1500):
                bench.advance(0.301, 0.0, excitation, h)
            tensions = []
            for _ in range(5):
                bench.advance(0.301, 0.0, excitation, h)
                tensions.append(bench.tension(0.301, 0.0, excitation))
            steps = np.diff(tensions)
            assert steps.max() < 1e-6 or steps.min() > -1e-6
            assert np.ptp(tensions) <= 2e-2 * max(tensions[0], 1.0)
            if h >= 1e-2 and excitation > 0.0:
                assert tensions[-1] == pytest.approx(expected, rel=1e-6)


def test_slack_muscle_has_no_force() -> None:
    """Without activation, damping and passive force the tendon becomes and stays slack."""
    bench = Bench(("hill_thelen2003", ELASTIC | {"minimum_activation": 0.0}))
    assert bench.start(0.295, 1.0) > 500.0
    for _ in range(3000):
        bench.advance(0.295, 0.0, 0.0, 1e-3)
    assert bench.tension(0.295, 0.0, 0.0) < 1e-9
    bench.move(0.26)
    bench.laws.set_states([0.0, 0.07])
    for length in (0.26, 0.25, 0.24):
        bench.advance(length, -0.1, 0.0, 0.1)
        assert bench.tension(length - 0.01, 0.0, 0.0) == 0.0
        assert bench.laws.states[1] == pytest.approx(0.07)


@pytest.mark.parametrize("kind", KINDS)
def test_fibre_length_has_a_lower_bound(kind: str) -> None:
    bench = Bench((kind, PENNATE))
    bench.start(0.3, 1.0)
    for k in range(400):
        bench.advance(0.3 - 5e-4 * k, -0.5, 1.0, 1e-3)
    fibre = float(bench.laws.states[1])
    assert fibre >= 0.1 * math.sin(0.4)
    assert bench.tension(0.1, -0.5, 1.0) == 0.0
    assert bench.state_rates(0.1, -0.5, 1.0, [1.0, 0.03])[1] >= 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_activation_equals_its_differential_equation(kind: str) -> None:
    """Compare with DOP853 at 1e-12, and check the bounds of the activation."""
    bench = Bench((kind, HILL))
    for start, excitation in ((0.02, 1.0), (1.0, 0.0), (0.9, 0.3), (0.1, 0.5)):

        def rate(_: float, a: FloatArray, u: float = excitation) -> FloatArray:
            return bench.state_rates(0.3, 0.0, u, a)

        times = np.arange(1, 11) * 5e-3
        reference = solve_ivp(
            rate, (0.0, 0.05), [start], "DOP853", times, rtol=1e-12, atol=1e-14, max_step=1e-3
        ).y[0]
        bench.move(0.3)
        bench.laws.set_states([start])
        for expected in reference:
            for _ in range(5):
                before = float(bench.laws.states[0])
                bench.advance(0.3, 0.0, excitation, 1e-3)
                after = float(bench.laws.states[0])
                assert min(before, excitation) <= after <= max(before, excitation, 0.01)
            floor = 0.0 if kind == "hill_degroote2016" else 0.01
            assert after == pytest.approx(max(expected, floor), abs=2e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_rigid_tendon_is_the_limit_of_elastic_tendon(kind: str) -> None:
    stiff = {"tendon_strain": 1e-6, "pennation_at_optimal": 0.3}
    rigid, elastic = Bench((kind, HILL | stiff)), Bench((kind, ELASTIC | stiff))
    for length in (0.28, 0.3, 0.33):
        expected = rigid.start(length, 0.6)
        assert elastic.start(length, 0.6) == pytest.approx(expected, rel=1e-4)
