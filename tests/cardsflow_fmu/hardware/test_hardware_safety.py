"""Guard between controller and hardware, gravity compensation, and motor commands."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError, SimulationError
from cardsflow_fmu.experiment.settings.hardware import MotorSettings, SafetySettings
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.session.motors import MotorMap
from cardsflow_fmu.hardware.session.safety import Guard, TripError
from controllers import SpringMotors
from controllers.force_distribution.gravity_compensation import gravity_compensation
from sim_dart import DartDynamics

ROBOT = planar_2r()
REST = np.array([20.0, 10.0, 30.0, 10.0])
NONE = np.empty(0)
FORCES = st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4).map(np.array)


def guard(**settings: Any) -> Guard:
    made = Guard(ROBOT, SafetySettings().copy_with(**settings))
    made.start(1.0, REST)
    return made


@given(st.lists(FORCES, min_size=1, max_size=30), st.floats(0.0, 0.1), st.floats(10.0, 1e5))
def test_forces_are_always_within_bounds_and_rates(
    desired: list[np.ndarray], ramp: float, rate: float
) -> None:
    one = guard(ramp_in=ramp, force_rate=(rate,) * 4)
    before = one.forces
    np.testing.assert_array_equal(before, one.f_min)
    for k, f in enumerate(desired):
        given_ = one.limit(1.0 + 0.005 * k, 0.005, f)
        assert (given_ >= one.f_min).all()
        assert (given_ <= one.f_max).all()
        assert (np.abs(given_ - before) <= rate * 0.005 * (1 + 1e-12)).all()
        before = given_


def test_the_ramp_begins_at_rest_and_ends_at_the_desired_forces() -> None:
    one, desired = guard(ramp_in=0.4), np.array([50.0, 60.0, 10.0, 200.0])
    bounded = np.array([50.0, 60.0, 10.0, 100.0])
    for t, s in ((1.0, 0.0), (1.1, 0.25), (1.3, 0.75), (1.4, 1.0), (9.0, 1.0)):
        np.testing.assert_allclose(one.limit(t, 0.1, desired), REST + s * (bounded - REST))


def test_without_a_ramp_desired_forces_are_unchanged() -> None:
    desired = np.array([11.1, 22.2, 33.3, 44.4])
    np.testing.assert_array_equal(guard(ramp_in=0.0).limit(1.0, 1e-3, desired), desired)


def test_the_ramp_down_is_linear_and_ends_at_f_min() -> None:
    one = guard(ramp_in=0.0, ramp_down=0.05)
    top = one.limit(1.0, 0.01, np.array([50.0, 60.0, 10.0, 90.0]))
    falling = list(one.ramp_down(0.01))
    assert len(falling) == 5
    np.testing.assert_allclose(falling[0], one.f_min + 0.8 * (top - one.f_min))
    np.testing.assert_array_equal(falling[-1], one.f_min)
    assert not list(guard(ramp_down=0.0).ramp_down(0.01))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_force_that_is_not_finite_stops_the_run(value: float) -> None:
    with pytest.raises(TripError, match=f"desired force of muscle 'cable_3' is {value} N"):
        guard().limit(1.0, 1e-3, np.array([10.0, 10.0, value, 10.0]))


def test_positions_beyond_limit_and_margin_stop_the_run() -> None:
    one = guard(position_margin=(0.05, 0.1))
    one.check(np.array([3.19, -3.24]), NONE)
    with pytest.raises(TripError, match=r"'joint_1' is at 3\.2 rad, above .* 3\.142 .* 0\.05 rad"):
        one.check(np.array([3.2, 0.0]), NONE)
    with pytest.raises(TripError, match=r"'joint_2' is at -3\.3 rad, below .* -3\.142 .* 0\.1 rad"):
        one.check(np.array([0.0, -3.3]), NONE)


def test_tensions_beyond_their_limit_stop_the_run() -> None:
    one, q = guard(max_tension=(120.0, math.inf, 120.0, 120.0)), np.zeros(2)
    one.check(q, np.array([120.0, 1e6, 0.0, 0.0]))
    with pytest.raises(TripError, match=r"'cable_3' is 120\.5 N, above its limit of 120 N"):
        one.check(q, np.array([0.0, 0.0, 120.5, 0.0]))
    guard().check(q, np.full(4, 1e9))


def test_a_robot_far_from_its_start_pose_is_rejected() -> None:
    one = guard(start_tolerance=(0.1, 0.2))
    one.require_near(np.array([0.1, 0.2]), np.array([0.05, 0.0]))
    with pytest.raises(
        HardwareError, match=r"'joint_2' is at 0\.5 rad, .* start position is 0\.2 rad.* 0\.2"
    ):
        one.require_near(np.array([0.05, 0.5]), np.array([0.0, 0.2]))


def test_hardware_requires_a_maximum_force() -> None:
    muscles = [replace(m, f_max=math.inf) for m in ROBOT.muscles]
    with pytest.raises(InputError, match=r"muscles\.cable_1\.f_max"):
        Guard(ROBOT.with_muscles(muscles), SafetySettings())


def test_the_forces_at_rest_balance_gravity() -> None:
    q = np.array([-0.5, 0.5])
    dynamics = DartDynamics(ROBOT)
    f = gravity_compensation(dynamics, q)
    np.testing.assert_allclose(
        -dynamics.muscle_jacobian(q).T @ f, dynamics.gravity(q), rtol=0, atol=1e-8
    )
    assert (f >= dynamics.f_min - 1e-9).all()


def test_forces_at_rest_are_within_limits_if_none_balance_gravity() -> None:
    robot = random_robot(3)
    f = gravity_compensation(DartDynamics(robot), np.zeros(len(robot.coordinates)))
    assert ((f >= 5.0) & (f <= 200.0)).all()


K, D, R, COUNTS = 4000.0, 12.0, 0.02, 651.9
LENGTHS = np.array([0.31, 0.42, 0.53, 0.64])
RATES = np.array([0.1, -0.2, 0.0, 0.3])
AT_REST = np.zeros(4)
PULL = np.array([12.0, 80.0, 33.0, 10.0])
SPRINGS = SpringMotors([m.name for m in ROBOT.muscles], K, damping=D, spindle_radius=R)


def mapped(command: Any, **settings: Any) -> MotorMap:
    four = {key: (value,) * 4 for key, value in settings.items() if value is not None}
    settings_ = MotorSettings(
        command=command, stiffness=(K,) * 4, damping=(D,) * 4, **settings | four
    )
    return MotorMap(settings_, SPRINGS.muscle_names)


def test_force_commands_are_the_forces() -> None:
    motors = MotorMap(MotorSettings(), SPRINGS.muscle_names)
    motors.calibrate(LENGTHS, RATES, PULL)
    np.testing.assert_array_equal(motors.commands(PULL, LENGTHS, RATES, NONE, 1e-3), PULL)


@pytest.mark.parametrize(
    ("settings", "decode"),
    [
        ({}, lambda u: u),
        ({"offset": 0.1}, lambda u: 0.1 + u),
        ({"encoder_scale": COUNTS}, lambda u: u / COUNTS),
        ({"spindle_radius": R, "offset": 0.2}, lambda u: 0.2 - R * u),
        (
            {"spindle_radius": R, "encoder_scale": COUNTS, "offset": 0.2},
            lambda u: 0.2 - R * u / COUNTS,
        ),
    ],
)
def test_set_points_result_in_the_desired_forces(settings: dict[str, float], decode: Any) -> None:
    """The forces are computed by the spring law f = K (l - l0) + D l'."""
    u = mapped("length", **settings).commands(PULL, LENGTHS, RATES, NONE, 1e-3)
    np.testing.assert_allclose(SPRINGS.forces(LENGTHS, RATES, decode(u)), PULL, rtol=1e-9)


def test_the_error_for_a_command_that_is_not_finite_names_the_motor() -> None:
    weak = MotorSettings(command="length", stiffness=(K, 5e-324, K, K))
    motors = MotorMap(weak, SPRINGS.muscle_names)
    with pytest.raises(SimulationError, match="motor of 'cable_2' is not finite"):
        motors.commands(PULL, LENGTHS, RATES, NONE, 1e-3)


def test_counts_from_the_start_begin_at_zero() -> None:
    motors = mapped("length", offset=None, spindle_radius=R)
    motors.calibrate(LENGTHS, RATES, PULL)
    u = motors.commands(PULL, LENGTHS, RATES, NONE, 1e-3)
    np.testing.assert_allclose(u, 0.0, atol=1e-12)
    u = motors.commands(PULL + 4.0, LENGTHS, RATES, NONE, 1e-3)
    np.testing.assert_allclose(u, 4.0 / (K * R), rtol=1e-9)  # the spindle winds up df/K


@pytest.mark.parametrize("radius", [None, R])
def test_integrated_rates_equal_the_desired_set_points(radius: float | None) -> None:
    h, per = 2e-3, 1.0 if radius is None else -R
    motors = mapped("velocity", **({} if radius is None else {"spindle_radius": R}))
    motors.calibrate(LENGTHS, RATES, np.full(4, 10.0))
    l0 = SPRINGS.set_points(LENGTHS, RATES, np.full(4, 10.0))
    tensions = np.full(4, 10.0)
    for k in range(20):
        desired = PULL + k
        l0 = l0 + per * h * motors.commands(desired, LENGTHS, RATES, tensions, h)
        tensions = SPRINGS.forces(LENGTHS, RATES, l0)
        np.testing.assert_allclose(tensions, desired, rtol=1e-9)


def test_integrated_set_points_are_corrected_by_tensions() -> None:
    """A motor has slipped by 1 mm. Without measured tensions its force remains wrong."""
    h, desired = 1e-3, np.full(4, 40.0)
    errors = []
    for measured in (True, False):
        motors = mapped("velocity")
        motors.calibrate(LENGTHS, AT_REST, desired)
        l0 = SPRINGS.set_points(LENGTHS, AT_REST, desired) + 1e-3
        for _ in range(400):
            tensions = SPRINGS.forces(LENGTHS, AT_REST, l0)
            given_ = tensions if measured else NONE
            l0 = l0 + h * motors.commands(desired, LENGTHS, AT_REST, given_, h)
        errors.append(np.abs(SPRINGS.forces(LENGTHS, AT_REST, l0) - desired).max())
    assert errors[0] < 1e-6
    assert errors[1] == pytest.approx(K * 1e-3)
