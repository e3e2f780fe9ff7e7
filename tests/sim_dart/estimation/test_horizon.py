"""Moving horizon: the Kalman filter and scipy as references; outliers, slack and joint limits."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Literal

import numpy as np
import pytest
from scipy.optimize import minimize
from support.robots.estimated import STEP, Truth, require_repeatable_tick
from support.robots.inertial import UnitReadings
from support.robots.robots import EXAMPLES, one_joint

from addin_sdfusion.robot import (
    WORLD,
    CableSet,
    Inertia,
    InputError,
    Muscle,
    Pose,
    Robot,
    ViaPoint,
    prismatic,
    read_robot,
)
from sim_dart import CoreDynamics, Plant
from sim_dart.core.arrays import FloatArray
from sim_dart.estimation.estimator import PoseEstimator
from sim_dart.estimation.settings import EstimatorSettings, Imu

Kind = Literal["kalman", "horizon"]
KINDS: tuple[Kind, ...] = ("kalman", "horizon")
MASS, UPPER = 2.0, 0.4
START = np.array([1.45, 0.1, -0.1, -1.2])
UNITS = [Imu("upper_arm_left", Pose((0.01, 0.02, 0.03), (0.3, 0.2, 0.1)))]
SETTINGS = EstimatorSettings(
    type="horizon", huber=0.0, gate=1e6, acceleration_noise=0.5, load_drift=2.0, start_sd=0.01
)
RAIL = replace(SETTINGS, length_noise=1e-3)
"""Settings of the linear problem; a horizon of all measurements needs no arrival cost."""


@cache
def arm() -> Robot:
    return read_robot(EXAMPLES / "roboy_left_arm" / "robot")


@cache
def rail() -> Robot:
    """Return a mass on a rail between two cables, whose lengths are linear in its position."""
    body = Inertia(MASS, (0.0, 0.0, 0.0), 0.1, 0.1, 0.1)
    robot = one_joint(
        "slider", prismatic((1.0, 0.0, 0.0)), body, unit="m", lower=-UPPER, upper=UPPER
    )
    hook = ViaPoint("slider", (0.0, 0.0, 0.0))
    cables = tuple(
        Muscle(name, (ViaPoint(WORLD, (x, 0.0, 0.0)), hook), 1.0, 100.0)
        for name, x in (("left", -1.0), ("right", 1.0))
    )
    return replace(robot, cable_sets=(CableSet("all", cables),), cable_set="all")


def lengths_on_rail(q: float) -> FloatArray:
    return np.array([1.0 + q, 1.0 - q])


def solve_by_scipy(
    settings: EstimatorSettings, start: float, readings: FloatArray, f: FloatArray
) -> FloatArray:
    """Return the states (q, qd, w) at the readings, shape (K, 3); slack cables have f = 0.

    The variables are the whitened start and process noise, so that constants of the noise densities
    and of the integrator are independent of the C code.
    """
    K, h = len(readings), STEP
    sd = np.array([settings.start_sd, settings.start_speed_sd, settings.start_load_sd], dtype=float)
    noise = float(np.asarray(settings.length_noise))
    kick, drift = (
        float(np.asarray(settings.acceleration_noise)),
        float(np.asarray(settings.load_drift)),
    )

    def states(z: FloatArray) -> FloatArray:
        x, found = np.array([start, 0.0, 0.0]) + sd * z[:3], []
        for k in range(K):
            a, b = z[3 + 2 * k : 5 + 2 * k] * np.sqrt(h)
            qd = x[1] + h * (f[1] - f[0] - x[2]) / MASS + kick * a
            x = np.array([x[0] + h * qd, qd, x[2] + drift * b])
            found.append(x)
        return np.array(found)

    J = np.array([(states(d) - states(0 * d)).ravel() for d in np.eye(3 + 2 * K)]).T
    base = states(np.zeros(3 + 2 * K))
    H = np.kron(np.eye(K), np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])) @ J
    r0 = (readings - [lengths_on_rail(q) for q in base[:, 0]]).ravel()
    is_slack = np.tile(f <= 0, K)

    def pulls(z: FloatArray) -> tuple[FloatArray, FloatArray]:
        r, most = (r0 - H @ z) / noise, settings.huber or np.inf
        return r, np.clip(r, -most, np.where(is_slack, 0.0, most))

    def cost(z: FloatArray) -> float:
        r, psi = pulls(z)
        return float(z @ z / 2 + (psi * r - psi**2 / 2).sum())

    def gradient(z: FloatArray) -> FloatArray:
        found: FloatArray = z - H.T @ pulls(z)[1] / noise
        return found

    rows = J[::3]
    bound = {"type": "ineq", "fun": lambda z: UPPER - base[:, 0] - rows @ z, "jac": lambda z: -rows}
    constraints = [bound] if settings.joint_limits else []
    solved = minimize(
        cost,
        np.zeros(3 + 2 * K),
        jac=gradient,
        method="SLSQP",
        constraints=constraints,
        options={"ftol": 1e-14, "maxiter": 1000},
    )
    return states(solved.x)


def run_on_rail(
    settings: EstimatorSettings, start: float, readings: FloatArray, f: FloatArray
) -> PoseEstimator:
    estimator = PoseEstimator(rail(), settings, [start])
    for lengths in readings:
        estimator.lengths[:], estimator.tensions[:] = lengths, f
        estimator.tick(STEP)
    return estimator


CASES = {
    "huber": (replace(RAIL, huber=1.0, joint_limits=False), 0.1, np.array([30.0, 20.0])),
    "limit": (RAIL, UPPER - 1e-3, np.array([60.0, 20.0])),
    "slack": (replace(RAIL, joint_limits=False), 0.1, np.array([10.0, 0.0])),
    "all": (replace(RAIL, huber=1.0), UPPER - 1e-3, np.array([30.0, 0.0])),
}


@pytest.mark.parametrize("case", CASES)
def test_program_equals_scipy(case: str) -> None:
    """All readings of a linear problem are in the horizon: outliers, a joint limit, slack cables.

    The mass moves away from its limit, so that no impact occurs.
    """
    settings, start, f = CASES[case]
    settings = replace(settings, start_speed_sd=1e-6)
    random = np.random.default_rng(5)
    readings = np.array([lengths_on_rail(start + 1e-3) for _ in range(7)])
    readings += random.normal(0.0, 1e-3, readings.shape)
    readings[2:4] += np.array([0.02, 0.01])
    expected = solve_by_scipy(settings, start, readings, f)
    estimator = run_on_rail(settings, start, readings, f)
    assert estimator.array("iterations", 1)[0] > 0
    x = estimator.array("x", 7, 3)
    assert np.allclose(x[:, 0], expected[:, 0], atol=2e-8)
    assert np.allclose(x, expected, atol=1e-4)
    plain = run_on_rail(replace(settings, huber=0.0, joint_limits=False), start, readings, f)
    assert case == "slack" or np.abs(x - plain.array("x", 7, 3))[:, 0].max() > 1e-4
    if settings.joint_limits:
        assert np.isclose(x[:, 0].max(), UPPER, atol=1e-8)


def test_outlier_of_a_slack_cable_is_ignored() -> None:
    """A length far below l(q) is impossible; far above it is not informative."""
    settings, start, f = CASES["slack"]
    readings = np.array([lengths_on_rail(start) for _ in range(10)])
    found = []
    for error in (0.5, -0.5):
        readings[5:, 1] += error
        found.append(run_on_rail(replace(settings, huber=1.0, gate=5.0), start, readings, f).q[0])
        readings[5:, 1] -= error
    assert np.isclose(*found, atol=1e-4)


def posterior_on_rail(
    settings: EstimatorSettings, start: float, readings: FloatArray, f: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return mean and covariance of the last (q, qd, w, offsets) given all readings.

    The states are linear in the start and the process noise, in standard deviations.
    """
    K, h = len(readings), STEP
    sd = np.array([settings.start_sd, settings.start_speed_sd, settings.start_load_sd], dtype=float)
    drifts = np.array(
        [settings.acceleration_noise, settings.load_drift, *2 * [settings.offset_drift]],
        dtype=float,
    )
    first = np.append(sd, 2 * [float(np.asarray(settings.start_offset_sd))])

    def states(z: FloatArray) -> FloatArray:
        x, found = np.array([start, 0.0, 0.0, 0.0, 0.0]) + first * z[:5], []
        for k in range(K):
            kicks = np.sqrt(h) * drifts * z[5 + 4 * k : 9 + 4 * k]
            qd = x[1] + h * (f[1] - f[0] - x[2]) / MASS + kicks[0]
            x = np.concatenate([[x[0] + h * qd, qd], x[2:] + kicks[1:]])
            found.append(x)
        return np.array(found)

    base = states(np.zeros(5 + 4 * K))
    J = np.array([states(d) - base for d in np.eye(5 + 4 * K)])
    C = np.array([[1.0, 0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0, 1.0]])
    H = (J @ C.T).reshape(len(J), -1) / np.asarray(settings.length_noise)
    r = (readings - np.array([1.0, 1.0]) - base @ C.T).ravel() / np.asarray(settings.length_noise)
    P = np.linalg.inv(np.eye(len(J)) + H @ H.T)
    last = J[:, -1].T
    return base[-1] + last @ P @ H @ r, last @ P @ last.T


def test_offsets_are_the_posterior_of_all_measurements() -> None:
    """The filter equals the least-squares solution for all noise at once."""
    settings = replace(RAIL, type="kalman", offset_drift=0.01, start_offset_sd=2e-3)
    random, f = np.random.default_rng(8), np.array([30.0, 20.0])
    readings = lengths_on_rail(0.1) + random.normal(0.0, 2e-3, (12, 2))
    estimator = run_on_rail(settings, 0.1, readings, f)
    mean, covariance = posterior_on_rail(settings, 0.1, readings, f)
    state = np.concatenate([estimator.q, estimator.qd, estimator.w, estimator.offset_changes])
    assert np.allclose(state, mean, rtol=1e-9, atol=1e-12)
    assert np.allclose(estimator.covariance, covariance, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(("frames", "drift"), [(2, 0.0), (7, 0.0), (7, 0.01), (40, 0.0)])
def test_linear_estimate_equals_the_kalman_filter(frames: int, drift: float) -> None:
    """The arrival cost is exact, so that the length of the horizon has no effect."""
    random, f = np.random.default_rng(1), np.array([40.0, 30.0])
    readings = np.array([lengths_on_rail(0.1 + 1e-3 * k) for k in range(30)])
    readings += random.normal(0.0, 1e-3, readings.shape)
    settings = replace(RAIL, frames=frames, joint_limits=False, offset_drift=drift)
    horizon = run_on_rail(settings, 0.1, readings, f)
    kalman = run_on_rail(replace(settings, type="kalman"), 0.1, readings, f)
    for name, scale in (("q", 1e-3), ("qd", 1e-1), ("w", 1.0), ("offset_changes", 1e-3)):
        assert np.allclose(getattr(horizon, name), getattr(kalman, name), atol=1e-9 * scale), name
    assert np.allclose(horizon.covariance, kalman.covariance, rtol=1e-9, atol=1e-18)


def test_estimate_with_imus_equals_the_kalman_filter() -> None:
    """Roboy's arm moves little within the horizon, so that both linearisations nearly agree."""
    settings = replace(SETTINGS, acceleration_noise=0.05, start_sd=1e-3, joint_limits=False)
    truth, f = Truth(arm(), settings, START, 2, UNITS), holding_forces(START)
    horizon = PoseEstimator(arm(), settings, START, UNITS)
    kalman = PoseEstimator(arm(), replace(settings, type="kalman"), START, UNITS)
    for _ in range(25):
        truth.step(f)
        truth.measure(horizon, f)
        for name in ("lengths", "tensions", "gyroscope", "accelerometer"):
            getattr(kalman, name)[:] = getattr(horizon, name)
        assert horizon.tick(STEP)
        assert kalman.tick(STEP)
    assert (horizon.used, kalman.used) == (17, 17)
    assert np.allclose(horizon.q, kalman.q, atol=0.01 * kalman.sd[:4].max())
    assert np.allclose(horizon.sd, kalman.sd, rtol=0.01)


def holding_forces(q: FloatArray) -> FloatArray:
    """Return forces that approximately hold the arm."""
    dynamics = CoreDynamics(arm())
    L, f = dynamics.muscle_jacobian(q), np.full(dynamics.m, 40.0)
    forces: FloatArray = np.maximum(f - np.linalg.pinv(L.T) @ (dynamics.gravity(q) + L.T @ f), 5.0)
    return forces


def run_with_outliers(
    kind: Kind, share: float, seed: int, start_sd: float, size: float = 5e-3
) -> tuple[float, bool]:
    """Return the RMS error of q after 60 ticks, in [rad], and whether the estimate is valid."""
    settings = replace(
        SETTINGS, type=kind, huber=2.0, gate=5.0, start_sd=start_sd, joint_limits=False
    )
    truth, f = Truth(arm(), settings, START, seed), holding_forces(START)
    estimator, squares, random = PoseEstimator(arm(), settings, START), [], truth.random
    for k in range(160):
        truth.step(f)
        truth.measure(estimator, f)
        is_outlier = random.random(11) < share
        estimator.lengths[:] += is_outlier * random.uniform(-size, size, 11)
        estimator.tick(STEP)
        if k >= 60:
            squares.append(((estimator.q - truth.q) ** 2).sum())
    return float(np.sqrt(np.mean(squares))), estimator.valid


@pytest.mark.parametrize("kind", KINDS)
def test_estimate_recovers_from_outliers_in_the_first_readings(kind: Kind) -> None:
    """They mislead an estimate whose start pose is known to 50 mrad."""
    found = [run_with_outliers(kind, 0.05, seed, 0.05) for seed in range(6)]
    assert all(valid and error < 5e-3 for error, valid in found)


@pytest.mark.parametrize(("share", "most"), [(0.0, 1.02), (0.05, 0.97)])
def test_horizon_is_better_with_small_outliers_and_not_worse_without(
    share: float, most: float
) -> None:
    """Outliers of up to five standard deviations pass the gate of the filter."""
    errors = {
        kind: np.mean([run_with_outliers(kind, share, seed, 1e-3, 5e-4)[0] for seed in range(4)])
        for kind in KINDS
    }
    assert errors["horizon"] < most * errors["kalman"]


def test_horizon_without_a_solution_is_not_valid_until_it_converges() -> None:
    """Lengths of no pose cause a large shift in each linearisation."""
    settings = EstimatorSettings(type="horizon", start_sd=0.3, joint_limits=False)
    estimator, random = PoseEstimator(arm(), settings, START), np.random.default_rng(0)
    lengths = estimator.path_lengths(START)
    estimator.tensions[:] = 40.0
    found = []
    for k in range(10):
        estimator.lengths[:] = lengths + (random.uniform(-0.1, 0.1, 11) if k < 3 else 0.0)
        estimator.tick(STEP)
        found.append((estimator.status, estimator.valid))
    assert found[0] == ("not converged", False)
    assert found[-1] == ("tracking", True)
    assert ("not converged", True) not in found


def test_horizon_follows_an_arm_at_its_joint_limit() -> None:
    """The elbow is pushed against its upper limit; the filter estimates poses beyond it."""
    plant, dynamics, random = Plant(arm(), step=STEP), CoreDynamics(arm()), np.random.default_rng(0)
    goal = np.array([1.45, 0.0, 0.0, 0.0])
    plant.reset(goal - [0.0, 0.0, 0.0, 0.05], np.zeros(4))
    settings = EstimatorSettings(type="horizon")
    horizon = PoseEstimator(arm(), settings, plant.q)
    kalman = PoseEstimator(arm(), replace(settings, type="kalman"), plant.q)
    errors = []
    for k in range(400):
        q, L, f = plant.q, dynamics.muscle_jacobian(plant.q), np.full(11, 60.0)
        push = np.array([0.0, 0.0, 0.0, 2.0 + np.sin(12.0 * k * STEP)])
        torques = dynamics.gravity(q) + 40.0 * (goal - q) - 6.0 * plant.qd + push
        f = np.clip(f - np.linalg.pinv(L.T) @ (torques + L.T @ f), 2.0, 500.0)
        plant.step(f)
        noise = 1e-4 * random.normal(size=11)
        for estimator in (horizon, kalman):
            estimator.lengths[:], estimator.tensions[:] = plant.muscle_lengths + noise, f
            estimator.tick(STEP)
        assert horizon.valid
        assert horizon.q[3] <= 1e-8
        errors.append([horizon.q - plant.q, kalman.q - plant.q])
    own, other = np.sqrt(np.mean(np.square(errors).sum(axis=2), axis=0))
    assert plant.q[3] == 0.0
    assert own < 3e-3
    assert other > 10 * own


def test_restored_state_is_bit_identical() -> None:
    estimator = PoseEstimator(arm(), EstimatorSettings(type="horizon", frames=3), START, UNITS)
    estimator.lengths[:], estimator.tensions[:] = estimator.path_lengths(START), 40.0
    estimator.gyroscope[:], estimator.accelerometer[:] = (
        0.0,
        UnitReadings(arm(), UNITS).read(START, np.zeros(4), np.zeros(4))[:, 1],
    )
    for _ in range(5):
        estimator.tick(STEP)
    require_repeatable_tick(estimator)


def test_invalid_settings_are_rejected() -> None:
    with pytest.raises(InputError, match="frames must be from 2 to 1000, not 1"):
        EstimatorSettings(type="horizon", frames=1)
    with pytest.raises(InputError, match="huber must not be negative"):
        EstimatorSettings(huber=-1.0)
    with pytest.raises(InputError, match="type must be one of kalman, horizon, not 'mhe'"):
        EstimatorSettings(type="mhe")  # type: ignore[arg-type]
