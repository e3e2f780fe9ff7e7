"""Pose estimator: consistency, derivatives, outliers, and rejected settings."""

from __future__ import annotations

import ctypes
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from support.robots.bent_cables import with_bent_cables
from support.robots.estimated import STEP, Truth, draw_flower, require_repeatable_tick
from support.robots.inertial import UnitReadings
from support.robots.robots import EXAMPLES, one_joint

from addin_sdfusion.robot import (
    WORLD,
    CableModel,
    CableSet,
    Inertia,
    InputError,
    Muscle,
    Pose,
    Robot,
    UnknownNameError,
    ViaPoint,
    read_robot,
    revolute,
)
from sim_dart import CoreDynamics
from sim_dart.core.arrays import FloatArray
from sim_dart.estimation.estimator import PoseEstimator
from sim_dart.estimation.observability import observability
from sim_dart.estimation.settings import EstimatorSettings, Imu

SEEDS, TICKS = 50, 20
START = np.array([1.45, 0.1, -0.1, -1.2])
ELBOW = ("motor9", "motor10")
UNITS = [
    Imu("upper_arm_left", Pose((0.01, 0.02, 0.03), (0.3, 0.2, 0.1))),
    Imu("lower_arm_left", Pose((0.05, 0.0, 0.1), (0.0, 1.0, 0.0))),
]
"""95 % of a chi-squared distribution with at least 600 degrees of freedom are within 1.96 sd."""


@pytest.fixture(scope="module")
def arm() -> Robot:
    return read_robot(EXAMPLES / "roboy_left_arm" / "robot")


def holding_forces(arm: Robot, q: FloatArray) -> FloatArray:
    """Return forces that approximately hold the arm."""
    dynamics = CoreDynamics(arm)
    L = dynamics.muscle_jacobian(q)
    f = np.full(dynamics.m, 40.0)
    return np.maximum(f - np.linalg.pinv(L.T) @ (dynamics.gravity(q) + L.T @ f), 5.0)


def estimator_at_rest(arm: Robot, settings: EstimatorSettings) -> tuple[PoseEstimator, FloatArray]:
    """Return an estimator at the start with its measurements, and the holding forces."""
    estimator, f = PoseEstimator(arm, settings, START), holding_forces(arm, START)
    estimator.lengths[:], estimator.tensions[:] = estimator.path_lengths(START), f
    return estimator, f


CONSISTENT = {
    "exact": {"acceleration_noise": 0.5},
    "simple": {"acceleration_noise": 0.5, "exact_transition": False},
    "imus": {"acceleration_noise": 0.05},
    "offsets": {"acceleration_noise": 0.5, "offset_drift": 2e-3, "start_offset_sd": 1e-3},
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CONSISTENT)
def test_errors_match_standard_deviations(arm: Robot, case: str) -> None:
    """Check the NEES of all states over seeds. The simple transition matrix is approximate."""
    settings = EstimatorSettings(load_drift=0.5, **CONSISTENT[case])
    if case == "offsets":
        settings = replace(settings, encoder_noise=1e-3)
    units = UNITS if case == "imus" else []
    f, squares = holding_forces(arm, START), []
    for seed in range(SEEDS):
        truth = Truth(arm, settings, START, seed, units)
        estimator = PoseEstimator(arm, settings, START, units)
        for _ in range(TICKS):
            truth.step(f)
            truth.measure(estimator, f)
            assert estimator.tick(STEP)
        error = truth.error(estimator)
        squares.append(error @ np.linalg.solve(estimator.covariance, error))
    size = len(error) * SEEDS
    assert abs(sum(squares) - size) < 1.96 * np.sqrt(2 * size)


def test_first_pose_with_unknown_offsets_matches_its_covariance(arm: Robot) -> None:
    """Errors of the pose and the offsets are correlated. The filter then separates them."""
    settings = EstimatorSettings(
        find_start=True, start_candidates=1, start_offset_sd=5e-4, exact_transition=False
    )
    estimator, random, squares = PoseEstimator(arm, settings, START), np.random.default_rng(5), []
    for _ in range(SEEDS):
        offsets = random.normal(0.0, 5e-4, 11)
        estimator.reset()
        estimator.lengths[:] = estimator.path_lengths(START) + offsets
        estimator.lengths += random.normal(0.0, 1e-4, 11)
        estimator.tensions[:] = 50.0
        assert estimator.find() == "tracking"
        assert not estimator.offset_changes.any()
        error, at = np.concatenate([estimator.q - START, -offsets]), np.r_[0:4, 12:23]
        squares.append(error @ np.linalg.solve(estimator.covariance[np.ix_(at, at)], error))
    assert abs(sum(squares) - 15 * SEEDS) < 1.96 * np.sqrt(2 * 15 * SEEDS)


def test_constant_offsets_are_those_of_a_filter_without_them(arm: Robot) -> None:
    """Offsets with a negligible drift are states, but change no bit of the other ones."""
    plain, _ = estimator_at_rest(arm, EstimatorSettings())
    tracking, _ = estimator_at_rest(arm, EstimatorSettings(offset_drift=1e-300))
    for estimator in (plain, tracking):
        estimator.lengths += 1e-4 * np.sin(np.arange(11))
        for _ in range(20):
            estimator.tick(STEP)
    assert len(tracking.offset_changes) == 11
    assert not tracking.offset_changes.any()
    assert np.array_equal(plain.q, tracking.q)
    assert np.array_equal(plain.sd, tracking.sd[:12])


def test_cable_friction_is_not_estimated_as_load(arm: Robot) -> None:
    """The model includes cable friction. An estimator without it estimates a load."""
    rough = with_bent_cables(arm, 0.15, START)
    smooth = rough.with_muscles(replace(m, friction=0.0) for m in rough.muscles)
    settings = EstimatorSettings(acceleration_noise=0.05, load_drift=0.5)
    quiet = replace(settings, start_load_sd=0.0, load_drift=0.0)
    truth, f = Truth(rough, quiet, START, 3), holding_forces(rough, START)
    f[::2] *= 1.1  # the arm moves
    knows, lacks = (PoseEstimator(robot, settings, START) for robot in (rough, smooth))
    for _ in range(300):
        truth.step(f)
        for estimator in (knows, lacks):
            truth.measure(estimator, f)
            estimator.tick(STEP)
    assert knows.valid
    assert np.abs(truth.qd).max() > 0.1
    assert np.abs(knows.q - truth.q).max() < 1e-3
    assert np.abs(knows.w).max() < 0.2 * np.abs(lacks.w).max()


def test_imu_innovations_are_zero_at_the_true_state(arm: Robot) -> None:
    """At the true state the innovations of moving IMUs are zero."""
    settings = EstimatorSettings(start_load_sd=0.0, load_drift=0.0, acceleration_noise=0.0)
    settings = replace(settings, start_sd=1e-9, start_speed_sd=1e-9, gyroscope_noise=1e-4)
    settings = replace(settings, accelerometer_noise=1e-2, length_noise=0.0)
    settings = replace(settings, gyroscope_bias_sd=0.0, accelerometer_bias_sd=0.0)
    estimator = PoseEstimator(arm, settings, START, UNITS)
    estimator.qd[:] = before = np.array([0.5, -0.8, 1.1, 0.7])
    estimator.tensions[:] = holding_forces(arm, START)
    state = estimator.get_state()
    estimator.gyroscope[:] = estimator.accelerometer[:] = np.nan
    estimator.tick(STEP)
    readings = UnitReadings(arm, UNITS).read(
        estimator.q.copy(), estimator.qd.copy(), (estimator.qd - before) / STEP
    )
    estimator.set_state(state)
    estimator.gyroscope[:], estimator.accelerometer[:] = readings[:, 0], readings[:, 1]
    estimator.tick(STEP)
    assert estimator.used == 12
    assert estimator.innovation < 1e-4  # 1 % of the noise: 1e-6 rad/s, 1e-4 m/s²


def test_exact_transition_equals_finite_differences(arm: Robot) -> None:
    estimator, _ = estimator_at_rest(arm, EstimatorSettings())
    estimator.qd[:] = qd = np.array([0.5, -0.8, 1.1, 0.7])
    n, h, state = 4, 1e-3, estimator.get_state()
    estimator.lengths[:] = np.nan

    def after(change: FloatArray) -> FloatArray:
        estimator.set_state(state)
        x = np.concatenate([START, qd, np.zeros(n)]) + change
        estimator.q[:], estimator.qd[:], estimator.w[:] = x.reshape(3, n)
        estimator.tick(h)
        return np.concatenate([estimator.q, estimator.qd])

    A = np.array([(after(d) - after(-d)) / 2e-5 for d in 1e-5 * np.eye(3 * n)]).T
    after(np.zeros(3 * n))
    assert np.allclose(estimator.array("transition", 2 * n, 3 * n), A, atol=1e-7)


def test_slack_elbow_muscles_make_the_elbow_unobservable(arm: Robot) -> None:
    """Check known values of this arm: 9, 20, 67 to 70, 32 to 40 mrad per mm."""
    observed = observability(
        arm, np.array([[1.45, 0.0, 0.0, -1.3]]), EstimatorSettings(length_noise=1e-3)
    )
    assert observed.is_observable
    assert np.allclose(observed.sd[0], [9.1e-3, 20e-3, 69.6e-3, 32e-3], rtol=0.02)
    assert set(observed.critical) == set(ELBOW)
    settings = EstimatorSettings(acceleration_noise=1.0)
    estimator, _ = estimator_at_rest(arm, settings)
    for _ in range(100):
        assert estimator.tick(STEP)
    slack = [muscle.name in ELBOW for muscle in arm.muscles]
    estimator.tensions[slack] = 0.0
    for _ in range(2000):
        estimator.tick(STEP)
    assert estimator.used == 9
    assert not estimator.valid
    assert estimator.sd[3] > 0.05 > 10 * estimator.sd[0]


def test_estimate_becomes_invalid_without_measurements(arm: Robot) -> None:
    """All muscles are slack if all tensions are 0. One measurement makes the estimate valid."""
    settings = EstimatorSettings(exact_transition=False, innovation_time=0.0205)
    estimator, f = estimator_at_rest(arm, settings)
    assert estimator.tick(STEP)
    estimator.tensions[:] = 0.0
    for k in range(30):
        estimator.tick(STEP)
        assert estimator.valid == (k < 20)
    assert (estimator.sd[:4] < 0.05).all()
    estimator.tensions[:] = f
    estimator.lengths[:] = estimator.path_lengths(estimator.q)
    estimator.tick(STEP)
    assert estimator.valid


def test_random_poses_are_found(arm: Robot) -> None:
    """The default settings find 95 % of 200 poses and reject the others."""
    low = np.array([c.lower for c in arm.coordinates])
    high = np.array([c.upper for c in arm.coordinates])
    random, said = np.random.default_rng(1), Counter[str]()
    estimator = PoseEstimator(arm, EstimatorSettings(find_start=True, exact_transition=False))
    for _ in range(200):
        q = random.uniform(low, high)
        estimator.reset()
        estimator.lengths[:] = estimator.path_lengths(q) + random.normal(0.0, 1e-4, 11)
        estimator.tensions[:] = 50.0
        status = estimator.find()
        if status == "tracking":
            error, P = estimator.q - q, estimator.covariance[:4, :4]
            status = "right" if error @ np.linalg.solve(P, error) < 40.0 else "wrong"
        said[status] += 1
    assert said["right"] >= 190
    assert not said["wrong"]


def test_ambiguous_pose_is_rejected() -> None:
    """A cable above a hanging link has the same length on both sides."""
    hinge = one_joint(
        "hinge",
        revolute((1.0, 0.0, 0.0)),
        Inertia(1.0, (0.0, 0.0, -0.2), 0.1, 0.1, 0.1),
        lower=-1.0,
        upper=1.0,
    )
    ends = (ViaPoint(WORLD, (0.0, 0.0, 0.5)), ViaPoint("hinge", (0.0, 0.0, -0.3)))
    pendulum = replace(
        hinge, cable_sets=(CableSet("all", (Muscle("cable", ends, 1.0, 100.0),)),), cable_set="all"
    )
    estimator = PoseEstimator(
        pendulum, EstimatorSettings(find_start=True, exact_transition=False), [0.1]
    )
    estimator.tensions[:] = 50.0
    estimator.lengths[:] = estimator.path_lengths([0.5])
    assert estimator.find() == "ambiguous"
    estimator.lengths[:] = 5.0
    assert estimator.find() == "no pose matches"
    estimator.tensions[:] = 0.0
    assert estimator.find() == "unobservable"
    assert not estimator.valid


def test_outlier_is_rejected(arm: Robot) -> None:
    estimator, _ = estimator_at_rest(arm, EstimatorSettings())
    for _ in range(50):
        assert estimator.tick(STEP)
    right, state = estimator.lengths.copy(), estimator.get_state()
    estimator.tick(STEP)
    q = estimator.q.copy()
    estimator.set_state(state)
    estimator.lengths[2] += 0.05
    assert estimator.tick(STEP)
    assert estimator.used == 10
    assert np.allclose(estimator.q, q, atol=1e-4)
    estimator.lengths[:] = right
    estimator.lengths[4] = np.nan
    estimator.tensions[5] = np.nan  # the last finite value is used
    assert estimator.tick(STEP)
    assert estimator.used == 10


@pytest.mark.parametrize("jump", [0.0, 200.0])
def test_noise_of_tensions_is_noise_of_accelerations(arm: Robot, jump: float) -> None:
    """Accelerations change by M^-1 L' e with errors e of the tensions, constant for 3 steps.

    A jump at a uniformly distributed time of the tick is an error with the mean square jump^2 / 3.
    """
    settings = EstimatorSettings(exact_transition=False)
    dynamics, f, covariances = CoreDynamics(arm), holding_forces(arm, START), []
    for scale in (0.0, 1.0):
        estimator = PoseEstimator(arm, settings, START)
        estimator.array("tension_noise", 11)[:] = 0.5 * scale
        estimator.array("tension_error", 11)[:] = 0.05 * scale
        estimator.tensions[:], estimator.lengths[:] = f, np.nan
        estimator.array("last_tensions", 11)[:] = f + jump
        estimator.tick(STEP / 3, 3)
        covariances.append(estimator.covariance[4:8, 4:8].copy())
    response = np.linalg.solve(dynamics.mass_matrix(START), dynamics.muscle_jacobian(START).T)
    expected = STEP**2 * (response * (0.5**2 + (0.05 * f) ** 2 + jump**2 / 3)) @ response.T
    np.testing.assert_allclose(covariances[1] - covariances[0], expected, rtol=0.02)


def test_estimate_follows_a_cable_that_breaks_within_a_tick(arm: Robot) -> None:
    """The cable breaks at the end of a tick of 5 ms, and the measured tension is 0."""
    settings, f = EstimatorSettings(encoder_noise=1e-4), holding_forces(arm, START)
    estimator, truth = PoseEstimator(arm, settings, START), Truth(arm, settings, START, 3)
    estimator.array("tension_error", 11)[:] = 0.05
    broken = f * (np.arange(11) != 6)
    for tick in range(26):
        for _ in range(5):
            truth.step(f if tick <= 20 else broken)
        truth.measure(estimator, f if tick < 20 else broken)
        estimator.tick(STEP, 5)
        if tick >= 20:
            assert estimator.used == 14  # all but the length of the slack cable
            assert np.abs(estimator.qd - truth.qd).max() < 0.05


def test_estimate_recovers_after_an_impact(arm: Robot) -> None:
    """An impulse at the elbow changes all velocities, so that most measurements exceed the gate."""
    settings = EstimatorSettings(encoder_noise=1e-4, exact_transition=False)
    truth, f = Truth(arm, settings, START, 3), holding_forces(arm, START)
    estimator, errors = PoseEstimator(arm, settings, START), []
    estimator.array("tension_error", 11)[:] = 0.05
    response = np.linalg.inv(CoreDynamics(arm).mass_matrix(START))[3]
    for tick in range(80):
        truth.qd += 5.0 * response / response[3] * (tick == 20)
        truth.step(f)
        truth.measure(estimator, f)
        estimator.tick(STEP)
        errors.append(np.abs(estimator.qd - truth.qd).max())
    assert errors[20] > 5.0
    assert max(errors[60:]) < 0.05
    assert estimator.valid


@pytest.mark.parametrize("offset", [5e-4, 2e-3, -0.02])
def test_unmodelled_offsets_invalidate_the_estimate(arm: Robot, offset: float) -> None:
    estimator, _ = estimator_at_rest(arm, EstimatorSettings())
    estimator.lengths[::2] += offset
    assert not any([estimator.tick(STEP) for _ in range(300)][100:])


def test_offsets_are_found_at_a_known_pose(arm: Robot) -> None:
    stretched = replace(
        CableModel("elastic_cable"), parameters=(("stiffness", 5e4), ("longest_rest_length", 2.0))
    )
    elastic = arm.with_muscles(replace(m, model=stretched) for m in arm.muscles)
    estimator, f = estimator_at_rest(elastic, EstimatorSettings())
    offset = np.random.default_rng(2).normal(0.0, 5e-3, 11)
    lengths = estimator.path_lengths(START) - f / 5e4 + offset
    assert np.allclose(estimator.home(START, lengths, f), offset, atol=1e-12)
    estimator.lengths[:] = lengths
    assert all(estimator.tick(STEP) for _ in range(50))
    assert estimator.used == 11
    assert np.allclose(
        estimator.q, START, atol=1e-3
    )  # the arm is released with approximately correct forces


def test_restored_state_is_bit_identical(arm: Robot) -> None:
    estimator, _ = estimator_at_rest(arm, EstimatorSettings())
    estimator.tick(STEP)
    require_repeatable_tick(estimator)


def test_invalid_settings_are_rejected(arm: Robot) -> None:
    with pytest.raises(InputError, match="gate must be positive and finite"):
        EstimatorSettings(gate=0.0)
    with pytest.raises(InputError, match="min_tension must not be negative"):
        EstimatorSettings(min_tension=-1.0)
    with pytest.raises(InputError, match="length_noise must be one number or 11"):
        PoseEstimator(arm, EstimatorSettings(length_noise=(1e-3, 2e-3)))
    with pytest.raises(UnknownNameError, match="no link 'hand'"):
        PoseEstimator(arm, imus=[Imu("hand")])
    with pytest.raises(InputError, match="start must have shape"):
        PoseEstimator(arm, start=[0.0])


@pytest.mark.native
def test_array_access_is_bounded(arm: Robot) -> None:
    """Arrays end within the memory, and unknown names are rejected."""
    estimator, _ = estimator_at_rest(arm, EstimatorSettings())
    length = ctypes.c_size_t()
    assert not estimator._c.estimator_array(estimator._handle, b"nothing", ctypes.byref(length))
    assert not estimator._c.estimator_open(
        estimator._core.handle, 1, np.array([99], np.int32).ctypes.data, 0, 8
    )


FIGURES = {
    "exact model, 0.1 mm": (1e-4, 1.0, {"load_drift": 0.0, "start_load_sd": 0.0}, 0.45e-3),
    "exact model, 0.5 mm": (5e-4, 1.0, {"load_drift": 0.0, "start_load_sd": 0.0}, 0.75e-3),
    "masses 10 % wrong, 0.1 mm": (1e-4, 1.1, {}, 0.75e-3),
    "masses 10 % wrong, 0.5 mm": (5e-4, 1.1, {}, 2.7e-3),
    "masses 10 % wrong, 0.5 mm, two units": (
        5e-4,
        1.1,
        {"gyroscope_bias_sd": 0.0, "accelerometer_bias_sd": 0.0},
        0.25e-3,
    ),
}
"""Length noise in [m], mass scale, settings, and largest RMS error of the hand in [m]."""


@pytest.mark.slow
@pytest.mark.parametrize("case", FIGURES)
def test_arm_tracks_the_flower_without_joint_encoders(case: str) -> None:
    """The loop at 200 Hz uses estimated state and load. CARDSFLOW_LONG_LOOPS runs it to the end."""
    noise, scale, changes, most = FIGURES[case]
    settings = EstimatorSettings(length_noise=noise, **changes)
    drawn = draw_flower(settings, UNITS if "units" in case else [], scale)
    print(f"\n{case}: {1e3 * drawn.rms:.3f} mm")
    assert drawn.rms <= most
    assert drawn.was_valid
