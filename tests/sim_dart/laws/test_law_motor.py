"""Series-elastic motor compared with closed forms of its linear equations, and its energy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from support.robots.muscle_bench import Bench

from addin_sdfusion.robot import CableModel
from addin_sdfusion.robot.model.muscle_laws import PRESETS, law_parameters
from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native
SLACK = {"rest_length": 1e3}
"""Rest length with which the spring is always slack."""


def _parameters(preset: str, **extra: float) -> dict[str, float]:
    given = dict(PRESETS[preset].parameters) | extra
    return law_parameters(CableModel("series_elastic_motor", tuple(given.items())))


def _bench(parameters: dict[str, float]) -> Bench:
    bench = Bench(("series_elastic_motor", parameters))
    bench.move(0.3)
    bench.laws.set_states(np.zeros(3))
    return bench


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("h", [1e-5, 1e-3, 0.02])
def test_step_response_of_a_free_motor(preset: str, h: float) -> None:
    """Compare with the closed form of a second-order system."""
    p = _parameters(preset, **SLACK)
    R, La = p["resistance"] + p["bridge_resistance"], p["inductance"]
    Ke, Kt, N = p["back_emf_constant"], p["torque_constant"], p["gear_ratio"]
    J, V = p["motor_inertia"] + p["gear_inertia"], 12.0
    half, product = R / (2 * La), Ke * Kt / (La * J)
    root = np.sqrt(complex(half**2 - product))
    a, b = -half + root, -half - root
    bench = _bench(p)
    end = V / (Ke * N)  # speed at which the back EMF equals the voltage
    for k in range(1, round(0.04 / h) + 1):
        bench.advance(0.3, 0.0, V, h)
        if k % max(1, round(2e-3 / h)):
            continue
        t = k * h
        ea, eb = np.exp(a * t), np.exp(b * t)
        speed = end * (1 + (b * ea - a * eb) / (a - b))
        angle = end * (t + (b * (ea - 1) / a - a * (eb - 1) / b) / (a - b))
        rate = end * a * b * (ea - eb) / (a - b)
        expected = [J * N * rate / Kt, speed, angle]
        assert np.abs(np.imag(expected)).max() < 1e-9
        np.testing.assert_allclose(bench.laws.states, np.real(expected), rtol=1e-10, atol=1e-11)


@pytest.mark.parametrize("preset", PRESETS)
def test_motor_winding_against_the_spring(preset: str) -> None:
    """Compare with the matrix exponential while the efficiency is constant and the cable taut."""
    p = _parameters(preset, stiffness=3000.0, rest_length=0.3)
    R, La = p["resistance"], p["inductance"]
    Ke, Kt, N = p["back_emf_constant"], p["torque_constant"], p["gear_ratio"]
    J, r, k, eta = p["motor_inertia"] + p["gear_inertia"], p["spindle_radius"], 3000.0, 0.59
    rho = eta + (1 / eta - eta) * (math.tanh(-5.0) + 1) / 2
    A = np.zeros((4, 4))
    A[0] = [-R / La, -Ke * N / La, 0.0, 12.0 / La]
    A[1] = [Kt / (N * J), 0.0, -r * r * k / (rho * N * N * J), 0.0]
    A[2, 1] = 1.0
    bench, x, h = _bench(p), np.array([0.0, 0.0, 1e-9, 1.0]), 1e-4
    bench.laws.set_states(x[:3])
    step = expm(A * h)
    for _ in range(150):
        bench.advance(0.3, 0.0, 12.0, h)
        x = step @ x
        if x[0] * x[1] < 0.0:
            break
        # the remaining error is the transition of the efficiency from i w = 0 to i w >> 0
        np.testing.assert_allclose(bench.laws.states, x[:3], rtol=2e-4, atol=1e-6)
    assert bench.tension(0.3, 0.0, 12.0) == pytest.approx(k * r * x[2], rel=2e-4)


@pytest.mark.slow
@pytest.mark.parametrize("preset", PRESETS)
def test_motion_equals_an_adaptive_integrator(preset: str) -> None:
    """Compare loads, moving paths and changing voltages to 0.02 A and 0.02 rad/s.

    The efficiency changes within a microsecond, in the middle of a substep.
    """
    p = _parameters(preset, rest_length=0.3)
    bench, other = _bench(p), Bench(("series_elastic_motor", p))
    h, reference = 1e-3, np.zeros(3)
    for k in range(120):
        speed, voltage = 0.1 * math.cos(0.07 * k), 14.0 * math.sin(0.05 * k)
        length = 0.3 + 0.1 / 70.0 * math.sin(0.07 * k)

        def rates(
            t: float,
            x: FloatArray,
            length: float = length,
            speed: float = speed,
            voltage: float = voltage,
        ) -> FloatArray:
            return other.state_rates(length + speed * t, speed, voltage, x)

        bench.advance(length, speed, voltage, h)
        found = solve_ivp(rates, (0.0, h), reference, "LSODA", rtol=1e-10, atol=1e-12)
        reference = found.y[:, -1]
        off = np.abs(bench.laws.states - reference) / np.array([10.0, 10.0, 1.0])
        assert off.max() < 2e-3, k


@pytest.mark.slow
def test_energy_is_balanced() -> None:
    """Electrical work equals heat, stored energy and gear losses, with Ke = Kt."""
    p = _parameters("roboy_myo_muscle", rest_length=0.3)
    bench, h = _bench(p), 2e-6
    J = (p["motor_inertia"] + p["gear_inertia"]) * p["gear_ratio"] ** 2
    electrical = heat = gear = 0.0
    for _ in range(20000):
        i, w, theta = bench.laws.states
        force = bench.tension(0.3, 0.0, 8.0)
        bench.advance(0.3, 0.0, 8.0, h)
        i2, w2, theta2 = bench.laws.states
        force2 = bench.tension(0.3, 0.0, 8.0)
        mean = (i + i2) / 2
        electrical += 8.0 * mean * h
        heat += p["resistance"] * (i * i + i2 * i2) / 2 * h
        into = p["torque_constant"] * p["gear_ratio"] * (i * w + i2 * w2) / 2 * h
        out = (force + force2) / 2 * p["spindle_radius"] * (theta2 - theta)
        gear += into - (J * (w2 * w2 - w * w) / 2) - out
    i, w, theta = bench.laws.states
    stored = (
        p["inductance"] * i * i / 2
        + J * w * w / 2
        + p["stiffness"] * (p["spindle_radius"] * theta) ** 2 / 2
    )
    assert electrical == pytest.approx(heat + stored + gear, rel=1e-5)
    assert gear > 1e-3 * electrical


@pytest.mark.parametrize("preset", PRESETS)
def test_motor_stalls_at_rest(preset: str) -> None:
    p = _parameters(preset, rest_length=0.25)
    bench = Bench(("series_elastic_motor", p))
    tension = bench.start(0.31, 1.5)
    rates = bench.state_rates(0.31, 0.0, 1.5, bench.laws.states)
    scale = np.array([1.5 / p["inductance"], 1e4, 1.0])
    assert np.abs(rates / scale).max() < 1e-9
    stall = p["gear_ratio"] * p["torque_constant"] / p["resistance"] / p["spindle_radius"] * 1.5
    assert tension == pytest.approx(0.59 * stall, rel=2e-4)
    for _ in range(100):
        bench.advance(0.31, 0.0, 1.5, 1e-3)
    assert bench.tension(0.31, 0.0, 1.5) == pytest.approx(tension, rel=1e-9)


def test_voltage_is_limited() -> None:
    one, other = (_bench(_parameters("roboy_myo_muscle", max_voltage=6.0)) for _ in range(2))
    one.advance(0.3, 0.0, 6.0, 1e-3)
    other.advance(0.3, 0.0, 600.0, 1e-3)
    assert one.laws.states.tolist() == other.laws.states.tolist()
