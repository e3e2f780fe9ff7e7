"""Motor commands for given muscle forces.

    force      u = f
    length     u = k (l0 - l_0)     or, of a spindle's angle,  u = k (l_0 - l0)/r
    velocity   u = k l0'            or                         u = -k l0'/r

with l0 = l - (f - D l')/K, the set point of the spring between motor and cable, k the encoder's
scale, l_0 the set point at which it counts 0, r the spindle's radius.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import SimulationError
from cardsflow_fmu.experiment.settings.hardware import MotorSettings
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import SpringMotors

_CORRECTION = 0.05
"""Part of the error of an integrated l0 that is corrected in a step: the measurement may be a step
old, and a full correction would oscillate."""
_STEPS_APART = 2.0
"""Largest number of steps between the measurements of a tension and of a length."""


class MotorMap:
    """The motors of m muscles.

    Raises:
        InputError: A constant is out of range; the message names the muscle.
    """

    def __init__(self, settings: MotorSettings, muscle_names: Sequence[str]) -> None:
        self._command = settings.command
        m = len(muscle_names)
        self._scale = np.array(settings.encoder_scale) if settings.encoder_scale else np.ones(m)
        self._offset = np.array(settings.offset) if settings.offset else np.zeros(m)
        self._takes_start = settings.offset is None
        self._takes_angles = bool(settings.spindle_radius)
        self._set_points = np.zeros(m)
        if settings.command == "force":
            return
        self._springs = SpringMotors(
            muscle_names,
            settings.stiffness,
            damping=settings.damping or 0.0,
            spindle_radius=settings.spindle_radius or 1.0,
        )

    def calibrate(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> None:
        """Initialise the set points, and the origin of the encoders if it is not given.

        Args:
            lengths: l, shape (m,), in [m].
            rates: l', shape (m,), in [m/s].
            forces: Held forces f, shape (m,), in [N].
        """
        if self._command == "force":
            return
        self._set_points = self._springs.set_points(lengths, rates, forces)
        if self._takes_start:
            self._offset = self._set_points

    def commands(
        self,
        forces: FloatArray,
        lengths: FloatArray,
        rates: FloatArray,
        tensions: FloatArray,
        h: float,
    ) -> FloatArray:
        """Return the commands for the next step, shape (m,).

        Args:
            forces: Desired f, shape (m,), in [N].
            lengths: l, shape (m,), in [m].
            rates: l', shape (m,), in [m/s].
            tensions: As measured, shape (m,), in [N]; shape (0,) if they are not.
            h: Length of the step, in [s].

        Raises:
            SimulationError: One is not a number.
        """
        if self._command == "force":
            return forces
        with np.errstate(over="ignore", invalid="ignore"):
            found = self._of_springs(forces, lengths, rates, tensions, h)
        if not np.isfinite(found).all():
            name = self._springs.muscle_names[int(np.isfinite(found).argmin())]
            what = f"the command of the motor of {name!r} is not finite; check hardware.motors"
            raise SimulationError(what)
        return found

    def _of_springs(
        self,
        forces: FloatArray,
        lengths: FloatArray,
        rates: FloatArray,
        tensions: FloatArray,
        h: float,
    ) -> FloatArray:
        desired = self._springs.set_points(lengths, rates, forces)
        if self._command == "length":
            self._set_points = desired
            return self._scale * self._positions(desired)
        self._correct(lengths, rates, tensions, h)
        speeds = (desired - self._set_points) / h
        self._set_points = desired
        return self._scale * (self._springs.speeds(speeds) if self._takes_angles else speeds)

    def _positions(self, set_points: FloatArray) -> FloatArray:
        if self._takes_angles:
            return self._springs.angles(set_points, self._offset)
        return set_points - self._offset

    def _correct(
        self, lengths: FloatArray, rates: FloatArray, tensions: FloatArray, h: float
    ) -> None:
        """Correct the drift of integrated set points by the measurements at taut cables.

        The part that a cable's motion between two measurements explains is left out.
        """
        if not tensions.size:
            return
        error = self._springs.set_points(lengths, rates, tensions) - self._set_points
        explained = _STEPS_APART * h * np.abs(rates)
        beyond = np.sign(error) * np.maximum(np.abs(error) - explained, 0.0)
        self._set_points = self._set_points + np.where(tensions > 0, _CORRECTION * beyond, 0.0)
