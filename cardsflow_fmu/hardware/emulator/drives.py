"""Motor models of an emulated robot: ideal force control, or set points of springs.

    force:     f = u
    length:    f = K (l - l0) + D l',   l0 = l_0 + u/k,   or l0 = l_0 - r u/k of a spindle's angle
    velocity:  the same,                l0' = u/k,        or l0' = -r u/k

with the command u and the symbols of `motors`, whose inverse this is. Tensions lie between 0 and
f_max. A first-order lag follows: f' = (f_d - f)/T, in closed form over a step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.settings.hardware import MotorSettings
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import SpringMotors


class Drive(Protocol):
    """A model of the motors of m muscles.

    Attributes:
        lower, upper: Bounds of a command, shape (m,).
    """

    lower: FloatArray
    upper: FloatArray

    def calibrate(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Start with these forces, and set the origin of the encoders if it is not given.

        Args:
            lengths: l, shape (m,), in [m].
            rates: l' = L qd, shape (m,), in [m/s].
            forces: f, shape (m,), in [N].
        """

    def resume(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Start from forces that have been held; the arguments are as above."""

    def tensions(
        self, command: FloatArray, lengths: FloatArray, rates: FloatArray, dt: float
    ) -> FloatArray:
        """Return the tensions over the next dt, before the lag, shape (m,), in [N].

        Args:
            command: Shape (m,).
            lengths: l, shape (m,), in [m].
            rates: l' = L qd, shape (m,), in [m/s].
            dt: In [s].
        """


class ForceDrive:
    """Ideal force control.

    Args:
        f_min, f_max: Bounds, shape (m,), in [N].

    Attributes:
        lower, upper: The same.
    """

    def __init__(self, f_min: FloatArray, f_max: FloatArray) -> None:
        self.lower, self.upper = f_min, f_max

    def calibrate(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """No encoder."""

    def resume(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """No state."""

    def tensions(
        self, command: FloatArray, lengths: FloatArray, rates: FloatArray, dt: float
    ) -> FloatArray:
        """Return the command, within the bounds."""
        bounded: FloatArray = np.clip(command, self.lower, self.upper)
        return bounded


class SpringDrive:
    """Motors with commands l0, or its rates, and springs in series.

    Args:
        settings: The motors; their command is a length or a velocity.
        muscle_names: m names.
        f_max: Largest force of a motor, shape (m,), in [N].

    Raises:
        InputError: A constant is out of range; the message names the muscle.

    Attributes:
        lower, upper: Bounds of a command: infinite, as the force is bounded.
    """

    def __init__(
        self, settings: MotorSettings, muscle_names: Sequence[str], f_max: FloatArray
    ) -> None:
        m = len(muscle_names)
        radius = np.array(settings.spindle_radius or (1.0,) * m)
        scale = np.array(settings.encoder_scale or (1.0,) * m)
        self._springs = SpringMotors(
            muscle_names,
            settings.stiffness,
            damping=settings.damping or 0.0,
            spindle_radius=radius,
        )
        self._metres = (-radius if settings.spindle_radius else 1.0) / scale
        self._offset = np.array(settings.offset or (0.0,) * m)
        self._takes_start = settings.offset is None
        self._takes_rates = settings.command == "velocity"
        self._f_max = f_max
        self.upper = np.full(m, math.inf)
        self.lower = -self.upper
        self._set_points = np.zeros(m)

    def calibrate(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Set the springs' set points for the forces, and the encoders' origin if not given."""
        self.resume(lengths, rates, forces)
        if self._takes_start:
            self._offset = self._set_points

    def resume(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Set each spring's set point for its force."""
        self._set_points = self._springs.set_points(lengths, rates, forces)

    def tensions(
        self, command: FloatArray, lengths: FloatArray, rates: FloatArray, dt: float
    ) -> FloatArray:
        """Return the forces of the springs at the set points at the end of dt."""
        commanded = self._metres * command
        before = self._set_points
        self._set_points = (
            before + commanded * dt if self._takes_rates else self._offset + commanded
        )
        forces = self._springs.forces(lengths, rates, self._set_points)
        bounded: FloatArray = np.minimum(forces, self._f_max)
        return bounded


def make_drive(settings: MotorSettings, robot: Robot) -> Drive:
    """Return the motors of a robot.

    Raises:
        InputError: A constant is out of range; the message names the muscle.
    """
    f_min, f_max = force_bounds(robot)
    if settings.command == "force":
        return ForceDrive(f_min, f_max)
    return SpringDrive(settings, [muscle.name for muscle in robot.muscles], f_max)


def force_bounds(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """f_min and f_max of a robot's muscles, shape (m,) each, in [N]."""
    return (
        np.array([muscle.f_min for muscle in robot.muscles]),
        np.array([muscle.f_max for muscle in robot.muscles]),
    )


def torque_bounds(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """tau_min and tau_max of a robot's motors at joints, shape (motors,) each, in [N·m] or [N]."""
    return (
        np.array([motor.tau_min for motor in robot.motors]),
        np.array([motor.tau_max for motor in robot.motors]),
    )


class Lag:
    """A first-order lag.

    Args:
        time_constant: T, in [s]; 0 for none.

    Raises:
        InputError: It is negative or not finite.
    """

    def __init__(self, time_constant: float) -> None:
        if not 0 <= time_constant < math.inf:
            raise InputError(f"the motors' time constant must be 0 s or more, not {time_constant}")
        self._time_constant = time_constant

    def filter(self, value: FloatArray, target: FloatArray, dt: float) -> FloatArray:
        """Return the output dt later, with a constant target; shape as given."""
        if self._time_constant == 0:
            return target
        output: FloatArray = target + (value - target) * math.exp(-dt / self._time_constant)
        return output
