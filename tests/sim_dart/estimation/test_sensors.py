"""Simulated sensors: noise, resolution, delay, and IMUs on moving links."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.inertial import UnitReadings
from support.robots.robot_sensors import RobotSensors
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import Pose, Robot, read_robot
from sim_dart.core.arrays import FloatArray
from sim_dart.estimation.sensors import SensorSettings
from sim_dart.estimation.settings import Imu
from sim_dart.muscles.paths import MusclePaths

START, STEP = np.array([1.45, 0.1, -0.1, -1.2]), 1e-3
UNITS = [Imu("lower_arm_left", Pose((0.05, 0.0, 0.1), (0.0, 1.0, 0.0)))]


@pytest.fixture(scope="module")
def arm() -> Robot:
    return read_robot(EXAMPLES / "roboy_left_arm" / "robot")


def readings(arm: Robot, count: int, settings: SensorSettings) -> FloatArray:
    """Return measurements of an arm with constant velocity, shape (count, channels)."""
    sensors, rows = RobotSensors(arm, settings, UNITS), []
    sensors.tensions[:] = 50.0
    sensors.qd[:] = qd = np.array([0.1, -0.2, 0.3, 0.1])
    for k in range(count):
        sensors.q[:] = START + k * STEP * qd
        sensors.read(STEP)
        rows.append(sensors.readings.copy())
    return np.array(rows)


@pytest.mark.native
def test_noise_is_normal_and_seeded(arm: Robot) -> None:
    truth = readings(arm, 2000, SensorSettings())
    noisy = readings(arm, 2000, SensorSettings(noise=1e-3, seed=7))
    noise = (noisy - truth) / 1e-3
    size = noise.size
    assert abs(noise.mean()) < 4.0 / np.sqrt(size)
    assert abs(noise.var() - 1.0) < 4.0 * np.sqrt(2.0 / size)
    assert abs((noise**4).mean() - 3.0) < 4.0 * np.sqrt(96.0 / size)
    together = noise.T @ noise / len(noise) - np.eye(noise.shape[1])
    assert np.abs(together).max() < 6.0 / np.sqrt(len(noise))
    assert abs((noise[1:] * noise[:-1]).mean()) < 4.0 / np.sqrt(size)
    assert np.array_equal(noisy, readings(arm, 2000, SensorSettings(noise=1e-3, seed=7)))
    assert not np.array_equal(noisy, readings(arm, 2000, SensorSettings(noise=1e-3, seed=8)))


def test_measurements_have_resolution_delay_and_stuck_channels(arm: Robot) -> None:
    truth = readings(arm, 50, SensorSettings())
    assert np.allclose(truth[0, :11], MusclePaths(arm).evaluate(START).lengths, atol=1e-15)
    rounded = readings(arm, 50, SensorSettings(resolution=1e-4))
    assert np.abs(rounded - truth).max() <= 0.5e-4 * (1 + 1e-9)
    assert np.allclose(rounded / 1e-4, np.round(rounded / 1e-4), atol=1e-6)
    late = readings(arm, 50, SensorSettings(delay=3))
    assert np.array_equal(late[3:], truth[:-3])
    assert np.array_equal(late[:3], truth[[0, 0, 0]])
    stuck = np.full(truth.shape[1], np.inf)
    stuck[4] = 0.02
    held = readings(arm, 50, SensorSettings(stuck=stuck))
    assert np.array_equal(np.delete(held, 4, axis=1), np.delete(truth, 4, axis=1))
    assert np.all(held[20:, 4] == held[19, 4])
    offset = readings(arm, 50, SensorSettings(offset=0.25))
    assert np.allclose(offset - truth, 0.25, atol=1e-12)


def test_imu_measurements_equal_finite_differences(arm: Robot) -> None:
    """Check a step of the velocity, and gravity at rest."""
    sensors = RobotSensors(arm, imus=UNITS)
    q, before, after = START, np.zeros(4), np.array([0.5, -0.8, 1.1, 0.7]) * 1e-3
    oracle = UnitReadings(arm, UNITS)
    sensors.q[:], sensors.qd[:] = q, before
    sensors.read(STEP)
    assert np.allclose(sensors.readings[-6:], oracle.read(q, before, before).ravel(), atol=1e-5)
    sensors.qd[:] = after
    sensors.read(STEP)
    expected = oracle.read(q, after, (after - before) / STEP).ravel()
    assert np.allclose(sensors.readings[-6:], expected, atol=1e-5)


def test_state_is_restored(arm: Robot) -> None:
    sensors = RobotSensors(arm, SensorSettings(noise=1e-3, delay=2), UNITS)
    sensors.q[:] = START
    for _ in range(5):
        sensors.read(STEP)
    state = sensors.remembered.copy()
    sensors.read(STEP)
    after = sensors.readings.copy()
    sensors.reset()
    sensors.remembered[:] = state
    sensors.read(STEP)
    assert np.array_equal(sensors.readings, after)


def test_state_that_is_not_finite_is_rejected(arm: Robot) -> None:
    sensors = RobotSensors(arm)
    sensors.q[1] = np.nan
    assert sensors.read(STEP) == 2
