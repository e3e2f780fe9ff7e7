"""Motor commands for given muscle forces.

    force      u = f
    length     u = k (l0 - l_0)     or, for spindle angles,  u = k (l_0 - l0)/r
    velocity   u = k l0'            or                       u = -k l0'/r

l0 = l - (f - D l')/K is the set point of the spring between motor and cable, k the encoder scale,
l_0 the set point at which the encoder reads 0, and r the spindle radius.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import SimulationError
from cardsflow_fmu.experiment.settings.hardware import MotorSettings
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import SpringMotors

_CORRECTION = 0.05
"""Fraction of the error of an integrated l0 that is corrected in a step. The measurement may be one
step old, so that a full correction would cause oscillation."""
_MAX_STEPS_APART = 2.0
"""Maximum number of steps between the measurements of a tension and of a length."""


class MotorMap:
    """Map from muscle forces to motor commands.

    Args:
        muscle_names: Names of the m muscles.

    Raises:
        InputError: A constant is out of range; the message names the muscle.
    """

    def __init__(self, settings: MotorSettings, muscle_names: Sequence[str]) -> None:
        self._command = settings.command
        m = len(muscle_names)
        self._scale = np.array(settings.encoder_scale) if settings.encoder_scale else np.ones(m)
        self._offset = np.array(settings.offset) if settings.offset else np.zeros(m)
        self._uses_start_as_origin = settings.offset is None
        self._uses_angles = bool(settings.spindle_radius)
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
        """Initialise the set points, and the encoder origin if it is not specified.

        Args:
            lengths: l, shape (m,), in [m].
            rates: l', shape (m,), in [m/s].
            forces: Current forces f, shape (m,), in [N].
        """
        if self._command == "force":
            return
        self._set_points = self._springs.set_points(lengths, rates, forces)
        if self._uses_start_as_origin:
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
            tensions: Measured tensions, shape (m,), in [N], or shape (0,) if not measured.
            h: Time step, in [s].

        Raises:
            SimulationError: A command is not finite.
        """
        if self._command == "force":
            return forces
        with np.errstate(over="ignore", invalid="ignore"):
            commands = self._spring_commands(forces, lengths, rates, tensions, h)
        if not np.isfinite(commands).all():
            name = self._springs.muscle_names[int(np.isfinite(commands).argmin())]
            problem = f"the command of the motor of {name!r} is not finite; check hardware.motors"
            raise SimulationError(problem)
        return commands

    def _spring_commands(
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
        return self._scale * (self._springs.speeds(speeds) if self._uses_angles else speeds)

    def _positions(self, set_points: FloatArray) -> FloatArray:
        if self._uses_angles:
            return self._springs.angles(set_points, self._offset)
        return set_points - self._offset

    def _correct(
        self, lengths: FloatArray, rates: FloatArray, tensions: FloatArray, h: float
    ) -> None:
        """Correct the drift of the integrated set points by the measurements at taut cables.

        The part of the error that the cable motion between two measurements explains is ignored.
        """
        if not tensions.size:
            return
        error = self._springs.set_points(lengths, rates, tensions) - self._set_points
        explained = _MAX_STEPS_APART * h * np.abs(rates)
        beyond = np.sign(error) * np.maximum(np.abs(error) - explained, 0.0)
        self._set_points = self._set_points + np.where(tensions > 0, _CORRECTION * beyond, 0.0)
