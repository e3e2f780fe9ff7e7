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

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu.experiment.settings.hardware import MotorSettings
from cardsflow_fmu.hardware.protocol.signals import actuator_bounds
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import SpringMotors


class Drive:
    """Model of the motors of m muscles.

    Raises:
        InputError: A constant is out of range; the message names the muscle.

    Attributes:
        lower, upper: Bounds of the commands, shape (m,). They are infinite for motors with springs,
            since the forces are limited.
    """

    def __init__(self, settings: MotorSettings, robot: Robot) -> None:
        m = len(robot.muscles)
        self.lower, self.upper = (bound[:m] for bound in actuator_bounds(robot))
        self._springs: SpringMotors | None = None
        if settings.command == "force":
            return
        radius = np.array(settings.spindle_radius or (1.0,) * m)
        scale = np.array(settings.encoder_scale or (1.0,) * m)
        self._springs = SpringMotors(
            [muscle.name for muscle in robot.muscles],
            settings.stiffness,
            damping=settings.damping or 0.0,
            spindle_radius=radius,
        )
        self._metres_per_unit = (-radius if settings.spindle_radius else 1.0) / scale
        self._offset = np.array(settings.offset or (0.0,) * m)
        self._uses_start_as_origin = settings.offset is None
        self._uses_rates = settings.command == "velocity"
        self._f_max = self.upper
        self.upper = np.full(m, math.inf)
        self.lower = -self.upper

    def calibrate(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Initialise the motors with forces, and set the encoder origin if it is not specified.

        Args:
            lengths: l, shape (m,), in [m].
            rates: l' = L qd, shape (m,), in [m/s].
            forces: f, shape (m,), in [N].
        """
        self.resume(lengths, rates, forces)
        if self._springs is not None and self._uses_start_as_origin:
            self._offset = self._set_points

    def resume(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Set the set point of each spring so that the spring has the given force."""
        if self._springs is not None:
            self._set_points = self._springs.set_points(lengths, rates, forces)

    def tensions(
        self, command: FloatArray, lengths: FloatArray, rates: FloatArray, dt: float
    ) -> FloatArray:
        """Return the tensions over the next dt, before the lag, shape (m,), in [N].

        Set points of springs are those at the end of the time step. Lengths and rates are as for
        `calibrate`.

        Args:
            command: Commands, shape (m,).
            dt: Time step, in [s].
        """
        if self._springs is None:
            within: FloatArray = np.clip(command, self.lower, self.upper)
            return within
        commanded = self._metres_per_unit * command
        before = self._set_points
        self._set_points = before + commanded * dt if self._uses_rates else self._offset + commanded
        forces = self._springs.forces(lengths, rates, self._set_points)
        bounded: FloatArray = np.minimum(forces, self._f_max)
        return bounded
