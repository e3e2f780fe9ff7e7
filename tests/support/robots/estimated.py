"""Robot and sensors that fulfil the model of an estimator."""

from __future__ import annotations

import os
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.models.python_law import control_law
from cardsflow_fmu.models.reference import make_reference
from controllers import ControlLoop
from sim_dart import CoreDynamics, Plant, compile_blob
from sim_dart.core.arrays import FloatArray
from sim_dart.core.library import Core
from sim_dart.estimation.estimated_robot import estimated_robot
from sim_dart.estimation.estimator import PoseEstimator
from sim_dart.estimation.settings import EstimatorSettings, Imu

from .inertial import UnitReadings
from .robots import EXAMPLES

STEP = 1e-3  # in [s]
_DRAWN = 6000  # number of simulated steps of the flower
_SETTLED = 0.2  # in [s]: the estimate may be invalid before


class Truth:
    """Ground truth, with the process and sensor noise of the settings of an estimator."""

    def __init__(
        self,
        robot: Robot,
        settings: EstimatorSettings,
        start: FloatArray,
        seed: int,
        units: list[Imu] | None = None,
    ) -> None:
        self.random, self._settings = np.random.default_rng(seed), settings
        self._core = Core(compile_blob(estimated_robot(robot)))
        n = len(robot.coordinates)
        self.q = start + self.random.normal(0.0, settings.start_sd, n)
        self.qd = self.random.normal(0.0, settings.start_speed_sd, n)
        self.w = self.random.normal(0.0, 1.0, n) * settings.start_load_sd
        self.biases = self.random.normal(0.0, 1.0, (len(units or []), 2, 3)) * np.array(
            [[settings.gyroscope_bias_sd], [settings.accelerometer_bias_sd]]
        )
        self.offsets = np.zeros(len(robot.muscles))
        if settings.estimates_offsets:
            self.offsets += (
                self.random.normal(0.0, 1.0, self.offsets.size) * settings.start_offset_sd
            )
        self._q, self._qd = self._core.array("q", n), self._core.array("qd", n)
        self.lengths = self._core.array("lengths", len(robot.muscles))
        self._readings = UnitReadings(robot, units or [])

    def step(self, f: FloatArray) -> None:
        """Advance with noise on the acceleration and on the rate of the load."""
        settings, n, core = self._settings, len(self.q), self._core
        core.move(core.handle, self.q.tobytes())
        self._q[:], self._qd[:] = self.q, self.qd
        assert not core.step(core.handle, f.tobytes(), (-self.w).tobytes(), STEP, 1)
        kick = np.sqrt(STEP) * self.random.normal(0.0, 1.0, n) * settings.acceleration_noise
        self._qdd = (self._qd + kick - self.qd) / STEP
        self.q, self.qd = self._q + STEP * kick, self._qd + kick
        self.w += np.sqrt(STEP) * self.random.normal(0.0, 1.0, n) * settings.load_drift
        if settings.estimates_offsets:
            kick = np.sqrt(STEP) * self.random.normal(0.0, 1.0, self.offsets.size)
            self.offsets += kick * settings.offset_drift
        core.move(core.handle, self.q.tobytes())

    def measure(self, estimator: PoseEstimator, f: FloatArray) -> None:
        """Write sensor readings to an estimator."""
        settings = self._settings
        noise = self.random.normal(0.0, 1.0, len(self.lengths)) * settings.length_noise
        estimator.lengths[:], estimator.tensions[:] = self.lengths + self.offsets + noise, f
        if np.any(settings.encoder_noise):
            noise = self.random.normal(0.0, 1.0, len(self.q)) * settings.encoder_noise
            estimator.encoders[:] = self.q + noise
        if len(self.biases):
            readings = self._readings.read(self.q, self.qd, self._qdd) + self.biases
            noise = self.random.normal(0.0, 1.0, readings.shape)
            estimator.gyroscope[:] = readings[:, 0] + settings.gyroscope_noise * noise[:, 0]
            estimator.accelerometer[:] = readings[:, 1] + settings.accelerometer_noise * noise[:, 1]

    def error(self, estimator: PoseEstimator) -> FloatArray:
        """Return the estimation error, in the order of the covariance."""
        state = [self.q, self.qd, self.w, self.biases.ravel()]
        estimates = [estimator.q, estimator.qd, estimator.w, estimator.biases.ravel()]
        if len(estimator.offset_changes):
            state, estimates = [*state, self.offsets], [*estimates, estimator.offset_changes]
        return np.concatenate(state) - np.concatenate(estimates)


class Drawn(NamedTuple):
    """Result of drawing the flower.

    Attributes:
        rms: RMS error of the hand, in [m].
        was_valid: Whether the estimate was always valid.
    """

    rms: float
    was_valid: bool


def draw_flower(
    settings: EstimatorSettings, units: list[Imu], mass_scale: float, seed: int = 0
) -> Drawn:
    """Run the example of Roboy's arm with an estimator in the loop, and unbiased sensors.

    Args:
        settings: Noise of the estimator and the sensors.
        units: IMUs.
        mass_scale: Scale of the true masses.
        seed: Seed of the noise.
    """
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm", {"plant.mass_scale": mass_scale})
    robot, start, random = experiment.robot, experiment.start.q, np.random.default_rng(seed)
    plant, dynamics = Plant(experiment.plant_robot, step=STEP), CoreDynamics(robot)
    plant.reset(start, np.zeros(dynamics.n))
    loop = ControlLoop(
        control_law(experiment, dynamics), dynamics.task_names, experiment.controller.period
    )
    loop.reset(dynamics.f_min)
    reference, readings = make_reference(experiment), UnitReadings(robot, units)
    assert experiment.reference.approach is not None
    estimator = PoseEstimator(robot, settings, start, units)
    errors, valid = [], True
    begin = round(experiment.reference.approach.duration / STEP)
    steps = experiment.run.steps if os.environ.get("CARDSFLOW_LONG_LOOPS") else begin + _DRAWN
    for k in range(steps):
        if k % 5 == 0:
            y = reference.evaluate(k * STEP)
            if k >= begin:
                errors.append(plant.task_position - y.q)
            loop.tick(estimator.q.copy(), estimator.qd.copy(), np.array(y), estimator.w.copy())
        before = plant.qd
        plant.step(loop.acting)
        noise = settings.length_noise * random.normal(0.0, 1.0, dynamics.m)
        estimator.lengths[:], estimator.tensions[:] = plant.muscle_lengths + noise, loop.acting
        if units:
            read = readings.read(plant.q, plant.qd, (plant.qd - before) / STEP)
            noise = random.normal(0.0, 1.0, read.shape)
            estimator.gyroscope[:] = read[:, 0] + settings.gyroscope_noise * noise[:, 0]
            estimator.accelerometer[:] = read[:, 1] + settings.accelerometer_noise * noise[:, 1]
        valid &= estimator.tick(STEP) or k * STEP < _SETTLED
    return Drawn(float(np.sqrt(np.mean(np.square(errors).sum(axis=1)))), valid)


def require_repeatable_tick(estimator: PoseEstimator) -> None:
    """Check that a tick after restoring the state has the same result, bit by bit."""
    state = estimator.get_state()
    estimator.tick(STEP)
    after = estimator.get_state()
    estimator.reset()
    estimator.set_state(state)
    estimator.tick(STEP)
    assert np.array_equal(estimator.get_state(), after)
