"""Schutte's muscle law: OpenSim's splines, fibre velocity in closed form, exact activation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.robots.muscle_bench import HILL, Bench

from addin_sdfusion.robot.model.function import derivatives
from addin_sdfusion.robot.model.schutte_curves import RANGES, SCHUTTES_CURVES

pytestmark = pytest.mark.native

KIND = "hill_schutte1993"
ELASTIC = HILL | {"elastic_tendon": 1.0, "pennation_at_optimal": 0.2, "fibre_damping": 0.05}
F0, OPTIMUM, SLACK = HILL.values()
RISE, FALL = 7.667 / 0.1, 1.459854 / 0.1


@pytest.mark.parametrize(("name", "behind"), [("active", 0.0), ("passive", 0.0), ("tendon", 1.0)])
def test_curves_are_splines_through_their_points(name: str, behind: float) -> None:
    bench = Bench((KIND, ELASTIC))
    curve = f"{name}_force_length"
    spline = SCHUTTES_CURVES[f"{curve}_curve"]
    low, high = RANGES[f"{curve}_curve"]
    x = np.linspace(low + 1e-4, 2.0 * high, 401)
    expected = np.array([derivatives(spline, float(at))[:2] for at in x])
    if name == "active":
        expected[expected[:, 0] < 0.0] = 0.0
    for column, is_slope in enumerate((False, True)):
        found = bench.curve(curve, x + behind, slope=is_slope)
        np.testing.assert_allclose(found, expected[:, column], rtol=1e-9, atol=1e-9)


def opensims_speed(force: float, active: float, damping: float) -> float:
    """Return the fibre velocity over vmax from the root that OpenSim uses."""
    if force < active:
        c = 0.15 * (force - active) / damping
        b = -0.15 * (force / 0.15 + active + damping) / damping
        return 0.5 * (-b - math.sqrt(b * b - 4.0 * c))
    k = 0.13 * 0.15 / 1.15
    c = -k / damping * (force - active)
    b = -(force / damping - 1.4 * active / damping - k)
    return 0.5 * (-b + math.sqrt(b * b - 4.0 * c))


def test_fibre_velocity_equals_opensim() -> None:
    bench = Bench((KIND, ELASTIC))
    rng = np.random.default_rng(3)
    active, passive, tendon = (
        SCHUTTES_CURVES[f"{name}_force_length_curve"] for name in ("active", "passive", "tendon")
    )
    compared = 0
    for _ in range(200):
        a, fibre = rng.uniform(0.05, 1.0), rng.uniform(0.055, 0.15)
        strain = rng.uniform(0.001, 0.03)
        cosine = math.sqrt(1.0 - (OPTIMUM * math.sin(0.2) / fibre) ** 2)
        length = fibre * cosine + SLACK * (1.0 + strain)
        pull = derivatives(tendon, (length - fibre * cosine) / SLACK - 1.0)[0]
        most = a * max(derivatives(active, fibre / OPTIMUM)[0], 0.0)
        force = pull / cosine - derivatives(passive, fibre / OPTIMUM)[0]
        assert bench.tension(length, 0.0, 0.0, [a, fibre]) == pytest.approx(F0 * pull, rel=1e-9)
        if force <= 0.0:
            continue  # OpenSim uses 0 in this case
        compared += 1
        rate = bench.state_rates(length, 0.0, 0.0, [a, fibre])[1] / (10.0 * OPTIMUM)
        assert rate == pytest.approx(opensims_speed(force, most, 0.05), rel=1e-7, abs=1e-9)
    assert compared > 100


@pytest.mark.parametrize(("a", "u"), [(0.1, 0.8), (0.9, 0.2), (0.0, 1.0), (0.5, 0.5)])
def test_activation_is_exact_for_any_step(a: float, u: float) -> None:
    bench = Bench((KIND, HILL))
    quickness = RISE * u + FALL if u >= a else FALL
    assert bench.state_rates(0.3, 0.0, u, [a])[0] == pytest.approx((u - a) * quickness)
    for h in (1e-4, 1e-2, 1.0):
        bench.tension(0.3, 0.0, u, [a])
        bench.advance(0.3, 0.0, u, h)
        expected = u + (a - u) * math.exp(-h * quickness)
        assert bench.laws.states[0] == pytest.approx(expected, rel=1e-13)
