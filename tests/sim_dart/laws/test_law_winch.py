"""Winches compared with closed forms and an adaptive integrator, and their energy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.robots.muscle_bench import WINCH, Bench

from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native

PLAIN = {
    "drum_radius": 0.05,
    "gear_ratio": 5.0,
    "motor_inertia": 2e-4,
    "drum_inertia": 1e-3,
    "axial_stiffness": 1e5,
    "max_torque": 10.0,
}
INERTIA, RADIUS = 25 * 2e-4 + 1e-3, 0.05
DRIVE = {"position_gain": 500.0, "velocity_gain": 5.0}


def _bench(kind: str = "winch", **extra: float) -> Bench:
    return Bench((kind, PLAIN | (DRIVE if kind == "winch_position" else {}) | extra))


def test_slack_drum_accelerates_against_bearing_friction() -> None:
    """Compare with the closed form of J w' = N u - b w - Tc."""
    b, dry, torque = 0.2, 0.5, 0.8
    bench = _bench(viscous_friction=b, dry_friction=dry, rest_length=50.0)
    bench.laws.set_states(np.zeros(2))
    end, tau = (5.0 * torque - dry) / b, INERTIA / b
    for _ in range(100):
        bench.advance(0.3, 0.0, torque, 1e-3)
    t = 0.1
    speed, angle = end * (1 - math.exp(-t / tau)), end * (t - tau * (1 - math.exp(-t / tau)))
    np.testing.assert_allclose(bench.laws.states, [speed, angle], rtol=1e-5)


def drum_pull(force: float) -> float:
    """Return the pull on the drum of an elastic cable at rest, g = f + EA e^2 / 2."""
    return force + force**2 / 2e5


def test_drum_oscillates_on_its_cable() -> None:
    """Compare small oscillations at constant torque with the slope of r g."""
    bench, length, h = _bench(lead_length=1.5), 2.0, 1e-4
    at_rest = bench.start(length, 1.0)
    assert drum_pull(at_rest) == pytest.approx(5.0 / RADIUS, rel=1e-11)
    held = bench.laws.states.copy()
    paid = -RADIUS * held[1] + 1.5
    slope = 1e5 * RADIUS**2 * (length + 1.5) ** 2 / paid**3  # d(r g)/d theta
    omega = math.sqrt(slope / INERTIA)
    bench.laws.set_states([1e-3, held[1]])
    for k in range(1, 4001):
        bench.advance(length, 0.0, 1.0, h)
        if k % 500 == 0:
            swing = 1e-3 / omega * math.sin(omega * k * h)
            assert bench.laws.states[1] - held[1] == pytest.approx(swing, abs=2e-3 * 1e-3 / omega)
            assert bench.tension(length, 0.0, 1.0) == pytest.approx(at_rest, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["winch", "winch_position"])
def test_motion_equals_an_adaptive_integrator(kind: str) -> None:
    """Check slack and taut cables, braking, back-driving, and a drive at its limit."""
    extra = {"viscous_friction": 0.05, "dissipation": 2e-3, "lead_length": 0.2, "drum_pitch": 0.01}
    bench, other = _bench(kind, **extra), _bench(kind, **extra)
    bench.start(0.5, 0.2)
    x, h = bench.laws.states.copy(), 1e-3
    for k in range(150):
        speed, length = 0.4 * math.cos(0.08 * k), 0.5 + 0.005 * math.sin(0.08 * k)
        command = 0.3 * math.sin(0.05 * k) if kind == "winch" else 0.5 + 0.04 * math.sin(0.07 * k)

        def rates(
            t: float, x: FloatArray, at: float = length, v: float = speed, u: float = command
        ) -> FloatArray:
            return other.state_rates(at + v * t, v, u, x)

        bench.advance(length, speed, command, h)
        x = solve_ivp(rates, (0.0, h), x, "LSODA", rtol=1e-10, atol=1e-12).y[:, -1]
        assert np.abs((bench.laws.states - x) / [50.0, 1.0]).max() < 2e-4, k
        x = bench.laws.states.copy()


def test_dry_friction_holds_the_drum_up_to_its_limit() -> None:
    """A cable torque r f within N u +- Tc does not move the drum."""
    bench = _bench(dry_friction=2.0)
    bench.start(1.0, 1.0)
    held = bench.laws.states.copy()
    for command in (1.0, 1.39, 0.61):
        for _ in range(50):
            bench.advance(1.0, 0.0, command, 1e-3)
        assert bench.laws.states.tolist() == held.tolist()
    for command, sign in ((1.41, 1.0), (0.59, -1.0)):
        bench.laws.set_states(held)
        bench.advance(1.0, 0.0, command, 1e-3)
        assert sign * bench.laws.states[0] > 0.0


def test_friction_only_dissipates_energy() -> None:
    """With random torques, J w^2 / 2 increases by at most the work of motor and cable."""
    bench, rng, h = (
        _bench(dry_friction=1.0, viscous_friction=0.02),
        np.random.default_rng(3),
        2.5e-4,
    )
    bench.start(1.0, 0.5)
    scale = lost = 0.0
    for k in range(3000):
        w, theta = bench.laws.states
        command = float(rng.uniform(-0.2, 1.0)) if k % 20 == 0 else command  # noqa: F821
        bench.advance(1.0, 0.0, command, h)
        w1, theta1 = bench.laws.states
        middle = np.array([(w + w1) / 2, (theta + theta1) / 2])
        pull = bench.tension(1.0, 0.0, command, middle)
        bench.laws.set_states([w1, theta1])
        work = (5.0 * command - RADIUS * drum_pull(pull)) * (theta1 - theta)
        taken = work - INERTIA * (w1**2 - w**2) / 2
        lost, scale = lost + taken, scale + abs(work)
        if w * w1 > 0.0:
            assert taken > 0.0
    assert lost > 0.05 * scale


@pytest.mark.slow
@pytest.mark.parametrize("dissipation", [0.0, 3e-3])
def test_motor_and_link_exchange_energy_over_drum_and_cable(dissipation: float) -> None:
    """The work N u theta' + f l' equals J w^2 / 2 + EA (l - l_u)^2 / 2 (l_u + l_lead) plus heat."""
    bench, h = _bench(dissipation=dissipation, lead_length=0.3, axial_stiffness=2e3), 2.5e-5
    bench.start(0.6, 1.0)

    def energy(length: float) -> float:
        w, theta = bench.laws.states
        paid = -RADIUS * theta
        stretch = max(length - paid, 0.0)
        return float(INERTIA * w**2 + 2e3 * stretch**2 / (paid + 0.3)) / 2

    work = exchanged = 0.0
    begin = energy(0.6)
    for k in range(8000):
        length, speed = 0.6 + 0.05 * math.sin(30 * k * h), 1.5 * math.cos(30 * (k + 0.5) * h)
        torque = 1.0 + 0.2 * math.sin(70 * k * h)
        x = bench.laws.states.copy()
        bench.advance(length, speed, torque, h)
        x1 = bench.laws.states.copy()
        force = bench.tension(length + speed * h / 2, speed, torque, (x + x1) / 2)
        bench.laws.set_states(x1)
        gained = 5.0 * torque * (x1[1] - x[1]) + force * speed * h
        work, exchanged = work + gained, exchanged + abs(gained)
    kept = energy(length + speed * h) - begin
    assert exchanged > 20.0
    if dissipation:
        assert work - kept > 5e-3 * exchanged
    else:
        assert work - kept == pytest.approx(0.0, abs=2e-6 * exchanged)


@pytest.mark.parametrize("periods", [3, 4, 8, 16])
def test_tension_command_of_a_drive_follows_the_path(periods: int) -> None:
    """At constant path velocity the mean tension of a period equals the desired tension."""
    bench, period, speed, wanted = _bench("winch_position", lead_length=0.5), 2e-3, 0.1, 30.0
    bench.start(1.0, 1.0)
    for k in range(80):
        length = 1.0 + speed * period * k
        bench.move(length, speed)
        command = float(bench.laws.invert([wanted], periods * period, period)[0])
        pulls = []
        for i in range(20):
            bench.advance(length + speed * 1e-4 * i, speed, command, 1e-4)
            pulls.append(bench.tension(length + speed * 1e-4 * (i + 1), speed, command))
    assert np.mean(pulls) == pytest.approx(wanted, rel=0.03)


def test_drive_holds_the_length() -> None:
    """At rest Kp (l_u - u) = r^2 g. A weak drive yields up to its torque limit."""
    for radius in (0.05, 0.2):
        bench = _bench("winch_position", lead_length=0.7, drum_radius=radius)
        force = bench.start(1.3, 1.298)
        paid = -radius * bench.laws.states[1]
        assert force == pytest.approx(1e5 * (1.3 - paid) / (paid + 0.7), rel=1e-9)
        assert drum_pull(force) == pytest.approx(500.0 * (paid - 1.298) / radius**2, rel=1e-9)
        rates = bench.state_rates(1.3, 0.0, 1.298, bench.laws.states)
        assert np.abs(rates).max() < 1e-6
    strong = bench.start(1.3, 0.9)
    assert drum_pull(strong) == pytest.approx(50.0 / 0.2, rel=1e-11)
    assert bench.start(1.3, 1.4) == 0.0


def test_one_turn_winds_a_helix() -> None:
    bench = _bench(drum_pitch=0.02, rest_length=3.0)
    for turns in (0.0, 1.0, 4.0):
        paid = 3.0 - turns * math.hypot(2 * math.pi * RADIUS, 0.02)
        length = 1.001 * paid
        force = bench.tension(length, 0.0, 0.0, [0.0, 2 * math.pi * turns])
        assert force == pytest.approx(1e5 * 0.001, rel=1e-10)


def test_torque_is_limited() -> None:
    one, other = (Bench(("winch", WINCH)) for _ in range(2))
    for bench, command in ((one, 2.0), (other, 1e4)):
        bench.start(0.3, 0.1)
        bench.advance(0.3, 0.0, command, 1e-3)
    assert one.laws.states.tolist() == other.laws.states.tolist()
