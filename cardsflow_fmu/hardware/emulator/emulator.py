"""Emulated robot of a device: the simulated plant with motors and sensors."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot, SimulationError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.hardware import (
    EmulatorSettings,
    FailureSettings,
    MotorSettings,
)
from cardsflow_fmu.experiment.settings.loads import DisturbanceSettings
from cardsflow_fmu.hardware.protocol.signals import actuator_bounds, require_forces
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.validation import named_vector, smallest_forces
from sim_dart import Plant

from .drives import Drive
from .failures import Failures, Measurement
from .sensors import Sensors

_ROUNDING = 1e-6
"""Tolerance of the number of steps, for rounding errors."""


class EmulatedRobot:
    """Simulated robot that implements `DeviceRobot`.

    With ideal motors and sensors, the states equal the states of the plant FMU exactly.

    Args:
        step: Internal time step, in [s].
        q: Start positions, shape (n,), in [rad] or [m], or None for the initial positions of the
            robot.
        qd: Start velocities, shape (n,), in [rad/s] or [m/s], or None for zero.
        disturbance: External forces, or None.
        motors: Settings of the motors, or None for ideal force control.
        emulator: Motor lag, errors of the sensors, and failures; None for an ideal robot.
        has_positions: Whether joint positions and velocities are measured.
        has_lengths: Whether muscle lengths are measured.
        has_tensions: Whether tensions are measured.
        safe_forces: Tensions in the safe state, a number or shape (m,), in [N], or None for f_min.
            Joint motors have zero torque in the safe state.

    Raises:
        InputError: A value is out of range.

    Attributes:
        drive: The motor model.
        commands: Number of commands: first the muscles, then the joint motors.
        bounds: Lower and upper bounds of the commands, shape (commands,) each.
        states: Number of measured values of q, qd, l, tension and torque.
    """

    def __init__(
        self,
        robot: Robot,
        step: float,
        *,
        q: Sequence[float] | None = None,
        qd: Sequence[float] | None = None,
        disturbance: DisturbanceSettings | None = None,
        motors: MotorSettings | None = None,
        emulator: EmulatorSettings | None = None,
        has_positions: bool = True,
        has_lengths: bool = True,
        has_tensions: bool = True,
        safe_forces: ArrayLike | None = None,
    ) -> None:
        self.plant = Plant(robot, step)
        n, m, motors_ = len(robot.coordinates), len(robot.muscles), len(robot.motors)
        self._m, self.commands = m, m + motors_
        lengths, tensions = has_lengths * m, has_tensions * (m + motors_)
        self.states = 2 * has_positions * n + lengths + tensions
        self._measured = (*2 * (has_positions,), has_lengths, *2 * (has_tensions,))
        self._start = (q, qd)
        self._disturbance = disturbance
        self.drive = Drive(motors or MotorSettings(), robot)
        lower, upper = actuator_bounds(robot)
        torques = lower[m:], upper[m:]
        self.bounds = (
            np.concatenate([self.drive.lower, torques[0]]),
            np.concatenate([self.drive.upper, torques[1]]),
        )
        self._torque_bounds, self._no_torque = torques, smallest_forces(*torques)
        emulator = emulator or EmulatorSettings()
        self._motor_lag = emulator.motor_lag
        self._sensors = Sensors(emulator, n, m)
        names = [muscle.name for muscle in robot.muscles]
        self._failures = Failures(emulator.failures, names, [c.name for c in robot.coordinates])
        self._safe_forces = lower[:m]
        if safe_forces is not None:
            self._safe_forces = named_vector("safe_forces", safe_forces, names)
        self.reset()

    @classmethod
    def from_experiment(
        cls, experiment: Experiment, emulator: EmulatorSettings | None = None
    ) -> EmulatedRobot:
        """Return the emulated robot of an experiment.

        Args:
            experiment: The experiment, which specifies plant, start state, disturbance and motors.
            emulator: Imperfections of the robot in addition to broken cables of the plant.

        Raises:
            InputError: A muscle has a muscle law, or a value is out of range. A custom law is not
                executed.
        """
        robot = experiment.plant_robot
        require_forces(robot, experiment.file)
        emulator = emulator or EmulatorSettings()
        breaks = zip(robot.muscles, experiment.plant.break_time, strict=True)
        broken = [
            FailureSettings(kind="broken", part=muscle.name, time=time)
            for muscle, time in breaks
            if time
        ]
        return cls(
            robot,
            experiment.plant.step,
            q=experiment.start.q,
            qd=experiment.start.qd,
            disturbance=experiment.disturbance,
            motors=experiment.hardware.motors,
            emulator=emulator.copy_with(failures=(*emulator.failures, *broken)),
            has_positions=experiment.hardware.has_positions,
            has_lengths=experiment.hardware.has_lengths,
            has_tensions=experiment.hardware.has_tensions,
        )

    @property
    def tension(self) -> FloatArray:
        """Tensions of the muscles, shape (m,), in [N]."""
        return self._tension.copy()

    def reset(self) -> None:
        """Return to the start state, with the tensions of the safe state."""
        plant = self.plant
        plant.reset(*self._start)
        self._advances, self._remainder, self._failed, self._steps = 0, 0.0, False, 0
        self._failures.reset()
        self._tension, self._torque = self._safe_forces, self._no_torque
        self._command: FloatArray | None = None
        self._sensors.reset(plant.q, plant.qd, plant.lengths_view, self._tension)
        self.drive.calibrate(plant.muscle_lengths, self._rates(), self._tension)

    def apply(self, command: FloatArray) -> None:
        """Apply the newest commands, shape (commands,)."""
        if self._command is None:
            plant = self.plant
            self.drive.resume(plant.muscle_lengths, self._rates(), self._tension)
        self._command = command.copy()

    def safe(self) -> None:
        """Apply the tensions of the safe state until the next command."""
        self._command = None

    def advance(self, dt: float) -> None:
        """Advance the simulation by dt, in [s].

        A remainder that is shorter than a step is added to the next call.

        Raises:
            SimulationError: The state has diverged. Further calls do nothing.
        """
        if self._failed:
            return
        try:
            self._advance(dt)
        except SimulationError:
            self._failed = True
            raise

    def _advance(self, dt: float) -> None:
        plant, step = self.plant, self.plant.step_size
        loads = self._loads(dt)
        self._remainder += dt
        steps = int(self._remainder / step + _ROUNDING)
        self._remainder -= steps * step
        for _ in range(steps):
            self._tension = self._lagged(self._tension, self._desired_tensions())
            self._torque = self._lagged(self._torque, self._desired_torques())
            self._tension = self._failures.change_tensions(
                self._tension, plant.lengths_view, self._steps * step
            )
            plant.step(self._tension, self._torque if self._torque.size else None, loads)
            self._steps += 1
        self._advances += 1
        if steps:
            lengths = self._failures.motor_lengths(plant.lengths_view)
            self._sensors.read(plant.q, plant.qd, lengths, self._tension, steps * step)

    def state(self) -> FloatArray:
        """Return the newest measurement of q, qd, l, tension and torque, shape (states,)."""
        read = self._sensors
        copy = Measurement(*(row.copy() for row in (read.q, read.qd, read.lengths, read.tensions)))
        self._failures.change_measurement(copy, self._steps * self.plant.step_size)
        rows = (copy.q, copy.qd, copy.lengths, copy.tensions, self._torque)
        measured = zip(self._measured, rows, strict=True)
        return np.concatenate([np.zeros(0), *(row for is_measured, row in measured if is_measured)])

    def _desired_tensions(self) -> FloatArray:
        """Return the tensions before the motor lag, shape (m,)."""
        if self._command is None:
            return self._safe_forces
        plant = self.plant
        return self.drive.tensions(
            self._command[: self._m], plant.lengths_view, self._rates(), plant.step_size
        )

    def _desired_torques(self) -> FloatArray:
        """Return the torques of the joint motors before the motor lag, shape (motors,)."""
        if self._command is None:
            return self._no_torque
        within: FloatArray = np.clip(self._command[self._m :], *self._torque_bounds)
        return within

    def _lagged(self, value: FloatArray, target: FloatArray) -> FloatArray:
        """Return a tension or torque after a step with a constant target."""
        if self._motor_lag == 0:
            return target
        share = math.exp(-self.plant.step_size / self._motor_lag)
        return target + (value - target) * share

    def _rates(self) -> FloatArray:
        rates: FloatArray = self.plant.muscle_jacobian @ self.plant.qd
        return rates

    def _loads(self, dt: float) -> FloatArray | None:
        """Return the external forces over the next dt, as the reference FMU outputs them."""
        disturbance, k = self._disturbance, self._advances
        if disturbance is None:
            return None
        time = (k - 1) * dt + dt if k else 0.0  # same rounding as in the co-simulation
        is_active = disturbance.begin <= time < disturbance.end
        return np.ravel(disturbance.forces) if is_active else None
