"""The arm with Hill-type muscles, simulated from its files through FMUs to results."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import read_robot
from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.simulation.run import simulate
from sim_dart import DartDynamics, MusclePaths

HILL_ARM = EXAMPLES / "hill_arm"
MUSCLES = (
    "shoulder_flexor",
    "shoulder_extensor",
    "brachialis",
    "triceps_lateral",
    "biceps",
    "triceps_long",
)
TARGETS = {0.2: (0.336, -0.43), 1.4: (0.5, -0.12), 2.5: (0.32, -0.15), 4.0: (0.336, -0.43)}


@pytest.fixture(scope="module")
def reached() -> Result:
    return simulate(Experiment.load(HILL_ARM), compute="python", coupling="direct")


@pytest.mark.slow
def test_hand_reaches_every_target(reached: Result) -> None:
    summary = reached.summary
    assert summary["status"] == "complete"
    assert summary["infeasible_ticks"] == 0
    assert summary["tracking"]["rms"] < 5e-4
    assert summary["tracking"]["max"] < 1e-3
    for t, (x, z) in TARGETS.items():
        row = round(t / 1e-3)
        assert reached["y.hand.x"][row] == pytest.approx(x, abs=1e-3)
        assert reached["y.hand.z"][row] == pytest.approx(z, abs=1e-3)


@pytest.mark.slow
def test_excitations_and_activations_are_within_their_range(reached: Result) -> None:
    for name in MUSCLES:
        u, a = reached[f"u.{name}"], reached[f"activation.{name}"]
        assert 0.0 <= u.min() <= u.max() <= 1.0
        assert 0.0 <= a.min() <= a.max() <= 1.0
        assert np.abs(np.diff(a)).max() < 0.05  # activation dynamics limit the rate
    assert max(reached[f"u.{name}"].max() for name in MUSCLES) > 0.1


def test_both_heads_of_the_triceps_wrap_over_the_elbow() -> None:
    """The moment arm equals the trochlea radius during contact, and its sign does not change."""
    robot = read_robot(HILL_ARM / "robot")
    paths, n = MusclePaths(robot), len(MUSCLES)
    levers = np.array(
        [paths.evaluate([0.2, q]).jacobian[:, 1].copy() for q in np.linspace(0.0, 2.4, 49)]
    )
    assert levers.shape == (49, n)
    for name in ("triceps_lateral", "triceps_long"):
        lever = levers[:, MUSCLES.index(name)]
        assert lever.min() >= 0.02 - 1e-12
        np.testing.assert_allclose(lever[20:], 0.02, atol=1e-12)
    for name in ("brachialis", "biceps"):
        assert levers[:, MUSCLES.index(name)].max() < -0.005


def test_muscles_hold_the_arm_at_rest(reached: Result) -> None:
    dynamics = DartDynamics(reached.experiment.robot)
    for t in (0.2, 2.55, 4.0):
        row = round(t / 1e-3)
        q = np.array([reached[f"q.{name}"][row] for name in ("shoulder", "elbow")])
        f = np.array([reached[f"tension.{name}"][row] for name in MUSCLES])
        torque = -dynamics.muscle_jacobian(q).T @ f
        np.testing.assert_allclose(torque, dynamics.gravity(q), rtol=0, atol=0.03)


def test_energy_equals_muscle_work_minus_joint_losses(reached: Result) -> None:
    work = reached["work.muscles"] + reached["work.damping"]
    energy = reached["energy.kinetic"] + reached["energy.potential"]
    assert np.ptp(energy) > 3.0
    np.testing.assert_allclose(energy - energy[0], work, atol=0.05)


@pytest.mark.slow
def test_weaker_muscles_require_more_excitation_until_they_saturate() -> None:
    def with_strength(part: float) -> Result:
        robot = read_robot(HILL_ARM / "robot")
        changes = {
            f"muscles.{m.name}.model.max_isometric_force": part
            * dict(m.model.parameters)["max_isometric_force"]
            for m in robot.muscles
        }
        return simulate(Experiment.load(HILL_ARM, changes), compute="python", coupling="direct")

    half, faint = with_strength(0.5), with_strength(0.08)
    assert half.summary["infeasible_ticks"] == 0
    assert half["u.biceps"].max() > 0.2
    assert faint.summary["infeasible_ticks"] > 100
    assert faint.summary["tracking"]["max"] > 0.02


@pytest.mark.slow
def test_elastic_tendons_track_almost_as_accurately() -> None:
    changes: dict[str, object] = {f"muscles.{name}.model.elastic_tendon": 1.0 for name in MUSCLES}
    result = simulate(Experiment.load(HILL_ARM, changes), compute="python", coupling="direct")
    assert result.complete
    assert result.summary["tracking"]["max"] < 0.01
    assert f"fibre_length.{MUSCLES[0]}" in result.names


@pytest.mark.slow
def test_both_integrators_agree(reached: Result) -> None:
    exact = Experiment.load(HILL_ARM, {"plant.integrator": "rk4"})
    other = simulate(exact, compute="python", coupling="direct")
    for name in ("y.hand.x", "y.hand.z"):
        np.testing.assert_allclose(other[name], reached[name], rtol=0, atol=1e-3)
