"""An elbow with two pneumatic muscles, simulated from its files through FMUs to results."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.simulation.run import simulate
from sim_dart import DartDynamics

PNEUMATIC_ELBOW = EXAMPLES / "pneumatic_elbow"
MUSCLES = ("flexor", "extensor")


@pytest.fixture(scope="module")
def followed() -> Result:
    return simulate(Experiment.load(PNEUMATIC_ELBOW), compute="python", coupling="direct")


@pytest.mark.slow
def test_joint_tracks_the_reference(followed: Result) -> None:
    summary = followed.summary
    assert summary["status"] == "complete"
    assert summary["infeasible_ticks"] == 0
    assert summary["ticks"] == 1000
    assert summary["tracking"]["rms"] < 1e-3
    assert summary["tracking"]["max"] < 2e-3


@pytest.mark.slow
def test_tensions_match_the_pressures(followed: Result) -> None:
    """F = p (3 L² - b²) / (4 pi n²), L = path length - cord length, in every row."""
    for name, cord in zip(MUSCLES, (0.07, 0.05), strict=True):
        L = followed[f"l.{name}"] - cord
        assert L.min() > 0.17
        assert L.max() < 0.3
        expected = followed[f"pressure.{name}"] * (3 * L**2 - 0.3**2) / (4 * np.pi * 2.0**2)
        np.testing.assert_allclose(followed[f"tension.{name}"], expected, rtol=1e-9)


def test_pressures_follow_set_points_with_the_time_constant(followed: Result) -> None:
    """p+ = u + (p - u) exp(-h / tau) between rows, with 0 <= u <= 6 bar."""
    for name in MUSCLES:
        p, u = followed[f"pressure.{name}"], followed[f"u.{name}"]
        assert u.min() >= 0.0
        assert u.max() <= 6e5
        np.testing.assert_allclose(p[1:], (u + (p - u) * np.exp(-1e-3 / 0.08))[:-1], rtol=1e-9)


def test_muscles_hold_the_weight_at_rest(followed: Result) -> None:
    dynamics = DartDynamics(followed.experiment.robot)
    for t in (1.9, 5.0):
        row = round(t / 1e-3)
        q = followed["q.elbow"][row : row + 1]
        f = np.array([followed[f"tension.{name}"][row] for name in MUSCLES])
        torque = -dynamics.muscle_jacobian(q).T @ f
        np.testing.assert_allclose(torque, dynamics.gravity(q), rtol=2e-3)
        assert torque[0] > 3.0


def test_energy_equals_muscle_work_minus_joint_losses(followed: Result) -> None:
    work = followed["work.muscles"] + followed["work.damping"]
    energy = followed["energy.kinetic"] + followed["energy.potential"]
    assert np.ptp(energy) > 1.0
    np.testing.assert_allclose(energy - energy[0], work, atol=0.01)


@pytest.mark.slow
def test_too_slow_pressure_is_reported() -> None:
    slow = {f"muscles.{name}.model.pressure_time_constant": 4.0 for name in MUSCLES}
    summary = simulate(
        Experiment.load(PNEUMATIC_ELBOW, slow), compute="python", coupling="direct"
    ).summary
    assert summary["status"] == "failed"
    assert summary["infeasible_ticks"] > 50
    assert summary["tracking"]["max"] > 0.01


@pytest.mark.slow
def test_both_integrators_agree(followed: Result) -> None:
    exact = Experiment.load(PNEUMATIC_ELBOW, {"plant.integrator": "rk4"})
    other = simulate(exact, compute="python", coupling="direct")
    np.testing.assert_allclose(other["q.elbow"], followed["q.elbow"], rtol=0, atol=1e-3)
