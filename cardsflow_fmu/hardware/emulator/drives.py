"""Motor models of an emulated robot: ideal force control, or motors with series springs.

    force:     f = u
    length:    f = K (l - l0) + D l',   l0 = l_0 + u/k,   or l0 = l_0 - r u/k for spindle angles
    velocity:  the same,                l0' = u/k,        or l0' = -r u/k

u is the command. These models are the inverse of those in `motors`, which defines the other
symbols. Tensions are between 0 and f_max. `EmulatedRobot` adds a first-order lag
f' = (f_d - f)/T, solved in closed form over a step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu.experiment.settings.hardware import MotorSettings
from cardsflow_fmu.hardware.protocol.signals import actuator_bounds
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import SpringMotors


class Drive(Protocol):
    """Interface of a model of the motors of m muscles.

    Attributes:
        lower, upper: Bounds of the commands, shape (m,).
    """

    lower: FloatArray
    upper: FloatArray

    def calibrate(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Initialise the motors with forces, and set the encoder origin if it is not specified.

        Args:
            lengths: l, shape (m,), in [m].
            rates: l' = L qd, shape (m,), in [m/s].
            forces: f, shape (m,), in [N].
        """

    def resume(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Initialise the motors with the forces of the safe state; arguments as for `calibrate`."""

    def tensions(
        self, command: FloatArray, lengths: FloatArray, rates: FloatArray, dt: float
    ) -> FloatArray:
        """Return the tensions over the next dt, before the lag, shape (m,), in [N].

        Args:
            command: Commands, shape (m,).
            dt: Time step, in [s].
        """


class ForceDrive:
    """Motors with ideal force control.

    Args:
        f_min, f_max: Force limits, shape (m,), in [N].

    Attributes:
        lower, upper: Force limits, shape (m,), in [N].
    """

    def __init__(self, f_min: FloatArray, f_max: FloatArray) -> None:
        self.lower, self.upper = f_min, f_max

    def calibrate(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Do nothing, since there is no encoder."""

    def resume(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Do nothing, since there is no state."""

    def tensions(
        self, command: FloatArray, lengths: FloatArray, rates: FloatArray, dt: float
    ) -> FloatArray:
        """Return the commands, clipped to the force limits."""
        bounded: FloatArray = np.clip(command, self.lower, self.upper)
        return bounded


class SpringDrive:
    """Motors with springs in series; commands are set points l0 or their rates.

    Args:
        settings: Settings of the motors, whose command is a length or a velocity.
        f_max: Maximum force of each motor, shape (m,), in [N].

    Raises:
        InputError: A constant is out of range; the message names the muscle.

    Attributes:
        lower, upper: Bounds of the commands. They are infinite, since the forces are limited.
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
        self._metres_per_unit = (-radius if settings.spindle_radius else 1.0) / scale
        self._offset = np.array(settings.offset or (0.0,) * m)
        self._uses_start_as_origin = settings.offset is None
        self._uses_rates = settings.command == "velocity"
        self._f_max = f_max
        self.upper = np.full(m, math.inf)
        self.lower = -self.upper
        self._set_points = np.zeros(m)

    def calibrate(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Set the set points of the springs, and the encoder origin if it is not specified."""
        self.resume(lengths, rates, forces)
        if self._uses_start_as_origin:
            self._offset = self._set_points

    def resume(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Set the set point of each spring so that the spring has the given force."""
        self._set_points = self._springs.set_points(lengths, rates, forces)

    def tensions(
        self, command: FloatArray, lengths: FloatArray, rates: FloatArray, dt: float
    ) -> FloatArray:
        """Return the spring forces for the set points at the end of the time step."""
        commanded = self._metres_per_unit * command
        before = self._set_points
        self._set_points = before + commanded * dt if self._uses_rates else self._offset + commanded
        forces = self._springs.forces(lengths, rates, self._set_points)
        bounded: FloatArray = np.minimum(forces, self._f_max)
        return bounded


def make_drive(settings: MotorSettings, robot: Robot) -> Drive:
    """Return the motor models of a robot.

    Raises:
        InputError: A constant is out of range; the message names the muscle.
    """
    f_min, f_max = (bound[: len(robot.muscles)] for bound in actuator_bounds(robot))
    if settings.command == "force":
        return ForceDrive(f_min, f_max)
    return SpringDrive(settings, [muscle.name for muscle in robot.muscles], f_max)
