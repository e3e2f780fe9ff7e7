"""What makes tensions of commands in an emulated robot: ideal motors, or springs that are wound.

    force:     f = u
    length:    f = K (l - l0) + D l',   l0 = l_0 + u/k,   or l0 = l_0 - r u/k of a spindle's angle
    velocity:  the same,                l0' = u/k,        or l0' = -r u/k

with the command u and the names of `motors`, whose inverse this is. A motor is no stronger than
f_max, and no cable pushes. A first-order lag follows: f' = (f_wanted - f)/T, in closed form over a
step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.hardware_settings import MotorSettings
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import SpringMotors


class Drive(Protocol):
    """The motors of m muscles, as far as they are known by what they are told.

    Attributes:
        lower, upper: Bounds of a command, shape (m,).
    """

    lower: FloatArray
    upper: FloatArray

    def calibrate(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Be at the start: the motors hold these forces, and count from there if they are to.

        Args:
            lengths: l, shape (m,), in [m].
            rates: l' = L qd, shape (m,), in [m/s].
            forces: f, shape (m,), in [N].
        """

    def resume(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Commands follow where these forces have been held; the arguments are as above."""

    def pull(
        self, command: FloatArray, lengths: FloatArray, rates: FloatArray, dt: float
    ) -> FloatArray:
        """The tensions wanted over the next dt, shape (m,), in [N].

        Args:
            command: Shape (m,).
            lengths: l, shape (m,), in [m].
            rates: l' = L qd, shape (m,), in [m/s].
            dt: In [s].
        """


class ForceDrive:
    """Motors that are told forces.

    Args:
        f_min, f_max: Bounds, shape (m,), in [N].

    Attributes:
        lower, upper: The same.
    """

    def __init__(self, f_min: FloatArray, f_max: FloatArray) -> None:
        self.lower, self.upper = f_min, f_max

    def calibrate(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Nothing to count."""

    def resume(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Nothing to remember."""

    def pull(
        self, command: FloatArray, lengths: FloatArray, rates: FloatArray, dt: float
    ) -> FloatArray:
        """The command, within the bounds."""
        bounded: FloatArray = np.clip(command, self.lower, self.upper)
        return bounded


class SpringDrive:
    """Motors that are told lengths l0, or their rates, and pull through springs.

    Args:
        settings: The motors; their command is a length or a velocity.
        muscle_names: m names.
        f_max: What a motor can pull, shape (m,), in [N].

    Raises:
        InputError: A constant is out of range; the message names the muscle.

    Attributes:
        lower, upper: Bounds of a command: none, as a motor's strength is bounded.
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
        """Wind each motor to where its spring makes its force, and count from there if asked to."""
        self.resume(lengths, rates, forces)
        if self._takes_start:
            self._offset = self._set_points

    def resume(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Wind each motor to where its spring makes its force."""
        self._set_points = self._springs.set_points(lengths, rates, forces)

    def pull(
        self, command: FloatArray, lengths: FloatArray, rates: FloatArray, dt: float
    ) -> FloatArray:
        """What the springs make at the set points at the end of dt."""
        told = self._metres * command
        before = self._set_points
        self._set_points = before + told * dt if self._takes_rates else self._offset + told
        forces = self._springs.forces(lengths, rates, self._set_points)
        bounded: FloatArray = np.minimum(forces, self._f_max)
        return bounded


def make_drive(settings: MotorSettings, robot: Robot) -> Drive:
    """The motors of a robot.

    Args:
        settings: What they take.
        robot: The robot.

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

    def follow(self, value: FloatArray, wanted: FloatArray, dt: float) -> FloatArray:
        """Where a value is dt later, shape as given, if `wanted` is held meanwhile."""
        if self._time_constant == 0:
            return wanted
        way: FloatArray = wanted + (value - wanted) * math.exp(-dt / self._time_constant)
        return way
