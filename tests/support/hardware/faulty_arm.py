"""Roboy's arm on the emulated device with failures: estimator, monitor and control loop.

One tick is one exchange at 200 Hz, as in a run with estimator.fmu.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from support.controllers.fault_monitor import KINDS, NOISE, STEP, FaultMonitor
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.settings.hardware import EmulatorSettings, FailureSettings
from cardsflow_fmu.hardware.emulator.emulator import EmulatedRobot
from cardsflow_fmu.hardware.emulator.failures import Failures
from cardsflow_fmu.models.python_law import control_law
from cardsflow_fmu.models.reference import make_reference
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import ControlLoop
from sim_dart import CoreDynamics
from sim_dart.estimation.estimator import PoseEstimator
from sim_dart.estimation.settings import EstimatorSettings

INNER = 1e-3  # step of plant and estimator, in [s]
LAG = 0.002  # of the motors, in [s]
BEFORE = 0.6  # time before a failure, in [s]
CONTACT = 100  # ticks of one load
OF_ESTIMATOR = {
    **{"length_noise": NOISE, "encoder_noise": NOISE, "acceleration_noise": 1.0},
    **{"load_drift": 3.0, "exact_transition": False},
}
LOAD_NOISE, LOAD_CHANGE = 0.05, 3.0  # of unknown loads, in [N m/sqrt(s)] and [N m]


class Moment(NamedTuple):
    """State of a run without failures: q, qd, w, tensions and time."""

    q: FloatArray
    qd: FloatArray
    w: FloatArray
    tensions: FloatArray
    time: float


class LoadedRobot(EmulatedRobot):
    """Emulated robot with an external force on its hand."""

    load: FloatArray | None = None

    def _loads(self, dt: float) -> FloatArray | None:
        return self.load


class FaultyArm:
    """Roboy's arm that draws the flower; its links are 10 % heavier than in the model.

    Args:
        has_tensions: Whether tensions are measured.
        rate: Accepted number of false alarms per hour.
        settings: Other settings of the estimator; without encoders, `encoder_noise` is 0.
    """

    def __init__(self, *, has_tensions: bool = True, rate: float = 0.1, **settings: Any) -> None:
        folder = EXAMPLES / "roboy_left_arm"
        self.experiment = Experiment.load(folder, {"plant.mass_scale": 1.1})
        robot, start = self.experiment.robot, self.experiment.start.q
        self.muscles = [muscle.name for muscle in robot.muscles]
        self.joints = [coordinate.name for coordinate in robot.coordinates]
        self.n, self.m, self.has_tensions = len(self.joints), len(self.muscles), has_tensions
        self.parts = [
            *self.muscles,
            *(f"length.{name}" for name in self.muscles),
            *(f"tension.{name}" for name in self.muscles),
            *self.joints,
        ]
        tension_noise = 0.05 if has_tensions else 0.0
        self._sensors = EmulatorSettings(motor_lag=LAG, noise=NOISE, tension_noise=tension_noise)
        self.device = LoadedRobot(
            self.experiment.plant_robot, INNER, q=start, emulator=self._sensors
        )
        dynamics = CoreDynamics(robot)
        self._f_min = dynamics.f_min
        encoders = float(settings.get("encoder_noise", NOISE))
        self._rough = np.sqrt(max(encoders**2 - NOISE**2, 0.0))  # noise beyond that of the device
        self._loop = ControlLoop(control_law(self.experiment, dynamics), dynamics.task_names, STEP)
        self.reference = make_reference(self.experiment).evaluate
        self.is_monitored = True
        self.estimator = PoseEstimator(
            robot,
            EstimatorSettings(**OF_ESTIMATOR | settings),
            start,
        )
        self._core = self.estimator._core
        self.tracks = self.estimator.settings.estimates_offsets
        self.monitor = FaultMonitor(self.n, self.m, rate)
        self.monitor.write(
            motor_lag=LAG, f_max=dynamics.f_max, load_noise=LOAD_NOISE, load_change=LOAD_CHANGE
        )
        self.monitor.write(encoder_noise=self.estimator.settings.encoder_noise)
        self.reset()

    def reset(
        self, seed: int = 0, failures: tuple[FailureSettings, ...] = (), at: Moment | None = None
    ) -> None:
        """Begin at the start of the flower, or at a moment of a run.

        Args:
            seed: Seed of the noise.
            failures: Failures, with times since this reset.
            at: Moment of a run, or None.
        """
        device, estimator = self.device, self.estimator
        device._sensors._settings = self._sensors.copy_with(seed=seed)
        self._random = np.random.default_rng(seed)
        device._failures = Failures(failures, self.muscles, self.joints)
        device.load = None
        device._start = (self.experiment.start.q, None) if at is None else (at.q, at.qd)
        device.reset()
        estimator.array("start", self.n)[:] = device._start[0]
        estimator.reset()
        self.monitor.reset()
        self._loop.reset(self._f_min if at is None else at.tensions)
        self.time = 0.0 if at is None else at.time
        self.ticks = 0
        if at is not None:
            estimator.qd[:], estimator.w[:] = at.qd, at.w
            device._tension = at.tensions.copy()
            plant = device.plant
            device._sensors.read(plant.q, plant.qd, plant.lengths_view, device._tension, STEP)
        self._command = self._loop.acting

    @property
    def moment(self) -> Moment:
        """The current state."""
        device = self.device
        parts = (device.plant.q.copy(), device.plant.qd.copy(), self.estimator.w.copy())
        return Moment(*parts, device.tension, self.time)

    def tick(self) -> int:
        """Measure, test, estimate and control. Return the number of parts with faults."""
        n, m, estimator = self.n, self.m, self.estimator
        state = self.device.state()
        estimator.encoders[:], estimator.lengths[:] = state[:n], state[2 * n : 2 * n + m]
        estimator.encoders[:] += self._random.normal(0.0, self._rough, n)
        tensions = state[2 * n + m : 2 * n + 2 * m]
        estimator.tensions[:] = tensions if self.has_tensions else self._command
        if self.is_monitored:
            self._test(tensions)
        count = self._move(round(STEP / INNER) if self.ticks else 0)
        reference = np.array(self.reference(self.time))
        self._loop.tick(estimator.q.copy(), estimator.qd.copy(), reference, estimator.w.copy())
        self._command = self._loop.acting
        self.device.apply(self._command)
        self.device.advance(STEP)
        self.time += STEP
        self.ticks += 1
        return count

    @property
    def found(self) -> set[tuple[str, str]]:
        """Kinds and parts of all faults that were found."""
        kinds = self.monitor.array("kind")
        return {(KINDS[int(kinds[p])], self.parts[p]) for p in np.flatnonzero(kinds)}

    def _move(self, steps: int) -> int:
        """Estimate, and test the motion, as estimator.fmu does. Return the number of faults."""
        estimator, monitor, n = self.estimator, self.monitor, self.n
        before, load = estimator.qd.copy(), estimator.w.copy()
        estimator.tick(INNER, steps)
        change = estimator.qd - estimator.array("shift", -1)[n : 2 * n] - before
        mobility = estimator.array("matrix", n * n).reshape(n, n)
        monitor.write(
            acceleration=change / STEP + mobility @ load,
            mobility=mobility,
            acting=estimator.array("last_tensions", self.m),
            velocity=before,
            load=load,
        )
        if self.is_monitored and self._is_near:
            return monitor.move(steps)
        return int(np.count_nonzero(monitor.array("kind")))

    def _test(self, tensions: FloatArray) -> None:
        """Test the measurements; leave out those of suspect sensors, as estimator.fmu does."""
        estimator, monitor, m = self.estimator, self.monitor, self.m
        monitor.write(
            lengths=estimator.lengths - (estimator.offset_changes if self.tracks else 0.0),
            encoders=estimator.encoders,
            tensions=tensions if self.has_tensions else np.full(m, np.nan),
            commands=self._command,
            q=estimator.q + STEP * estimator.qd * (self.ticks > 0),
        )
        is_near = False
        for _ in range(6):
            if not is_near:
                self._evaluate()
                is_near = monitor.fit_pose()
        self._is_near = is_near
        if is_near:
            monitor.tick()
        lost = (monitor.array("usable") == 0) | (monitor.array("suspect") != 0)
        estimator.lengths[lost[m : 2 * m]] = np.nan
        estimator.encoders[lost[3 * m :]] = np.nan

    def _evaluate(self) -> None:
        core, q = self._core, self.monitor.array("q")
        core.move(core.handle, q.tobytes())
        self.monitor.write(
            path_lengths=core.array("lengths", self.m),
            jacobian=core.array("jacobian", self.m * self.n),
        )


def random_failure(arm: FaultyArm, random: np.random.Generator, kinds: list[str]) -> Any:
    """Return a failure of a random kind, part and size, with a time after `BEFORE`."""
    kind = str(random.choice(kinds))
    part = str(random.choice(arm.joints if kind == "encoder_stuck" else arm.muscles))
    sign, share = random.choice([-1.0, 1.0]), random.uniform()
    values = {
        "jammed": 5e3 * 10.0**share,
        "weak": 0.2 + 0.6 * share,
        "off_pulley": sign * (0.005 + 0.015 * share),
        "length_bias": sign * (0.002 + 0.008 * share),
        "length_scale": 0.5 + 0.4 * share if sign < 0 else 1.1 + 0.4 * share,
    }
    own: dict[str, Any] = {"value": values[kind]} if kind in values else {}
    if kind == "length_swapped":
        own["other"] = str(random.choice([name for name in arm.muscles if name != part]))
    time = BEFORE + random.uniform(0.0, STEP)
    return FailureSettings(kind=kind, part=part, time=time, **own)


def expected_fault(failure: FailureSettings) -> tuple[str, str]:
    """Return the kind and part that the monitor must find.

    A cable off its pulley changes the measured length like an offset.
    """
    kind = "length_bias" if failure.kind == "off_pulley" else failure.kind
    sensor = kind.partition("_")[0]
    return kind, f"{sensor}.{failure.part}" if sensor in ("length", "tension") else failure.part


def hand_load(random: np.random.Generator) -> FloatArray:
    """Return no load, a payload up to 1 kg, or a contact force up to 15 N."""
    choice = random.uniform()
    if choice < 0.3:
        return np.zeros(3)
    if choice < 0.6:
        return np.array([0.0, 0.0, -random.uniform(2.0, 10.0)])
    force = random.normal(size=3)
    loaded: FloatArray = force * (random.uniform(3.0, 15.0) / np.linalg.norm(force))
    return loaded


def run_with_loads(arm: FaultyArm, seconds: float, seed: int) -> int:
    """Draw flowers with changing payloads and contacts. Return the number of alarms.

    Each load lasts 0.5 s and begins with a ramp of 50 ms.
    """
    random, alarms, after = np.random.default_rng(seed), 0, np.zeros(3)
    for tick in range(round(seconds / STEP)):
        if arm.time > arm.experiment.run.duration:
            arm.reset(int(random.integers(2**31)))
        if tick % CONTACT == 0:
            before, after = after, hand_load(random)
        arm.device.load = before + (after - before) * min(1.0, tick % CONTACT / 10)
        if arm.tick():
            print("false alarm at", round(tick * STEP, 3), arm.found, flush=True)
            arm.monitor.reset()
            alarms += 1
    return alarms
