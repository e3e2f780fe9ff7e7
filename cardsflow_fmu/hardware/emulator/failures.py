"""Failures of cables, motors and sensors of an emulated robot, at stated times.

broken          f = 0; the motor holds, so that length and tension sensors are constant and 0
jammed          f = f_0 + k (l - l_0), at least 0, with the force and length of the failure; the
                length at the motor remains l_0, apart from the noise of its sensor
weak            f is multiplied by a factor
off_pulley      the measured length jumps, in [m]
length_stuck    the measured length is constant
length_bias     the measured length has an offset, in [m]
length_drift    the offset of the measured length changes at a constant rate, in [m/s]
length_scale    changes of the measured length are multiplied by a factor
length_swapped  the measured lengths of two muscles are exchanged
tension_stuck   the measured tension is constant
tension_dead    the measured tension is 0
encoder_stuck   the measured joint position is constant, and its velocity is 0
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from addin_sdfusion.robot import UnknownNameError
from cardsflow_fmu.experiment.settings.hardware import FailureSettings
from cardsflow_fmu.utils.arrays import FloatArray


@dataclass
class Measurement:
    """Values of the sensors; failures change them in place.

    Attributes:
        q: Positions, shape (n,), in [rad] or [m].
        qd: Velocities, shape (n,), in [rad/s] or [m/s].
        lengths: Muscle lengths, shape (m,), in [m].
        tensions: Tensions, shape (m,), in [N].
    """

    q: FloatArray
    qd: FloatArray
    lengths: FloatArray
    tensions: FloatArray


class Failures:
    """Failures of a robot with m muscles and n coordinates.

    Raises:
        UnknownNameError: A muscle or a coordinate does not exist.
    """

    def __init__(
        self,
        settings: Sequence[FailureSettings],
        muscle_names: Sequence[str],
        coordinate_names: Sequence[str],
    ) -> None:
        self._settings, self._parts, self._others = settings, list[int](), list[int]()
        for k, failure in enumerate(settings):
            names = coordinate_names if failure.is_of_coordinate else muscle_names
            for part in (failure.part, failure.other or failure.part):
                if part not in names:
                    key = f"hardware.emulator.failures[{k}]"
                    raise UnknownNameError(failure.kind_of_part, part, names, key=key)
            self._parts.append(names.index(failure.part))
            self._others.append(names.index(failure.other or failure.part))
        self.reset()

    def reset(self) -> None:
        """Forget the values of sensors and motors at the failures."""
        self._motor: dict[int, tuple[float, float]] = {}
        self._sensor: dict[int, float] = {}

    def change_tensions(self, tensions: FloatArray, lengths: FloatArray, time: float) -> FloatArray:
        """Return the tensions of cables and motors with the failures until a time.

        Args:
            tensions: Tensions of working motors, shape (m,), in [N].
            lengths: True muscle lengths, shape (m,), in [m].
            time: Time since the start, in [s].
        """
        if not self._settings:
            return tensions
        changed = tensions.copy()
        for k, failure, i in self._active(time):
            if failure.kind == "broken":
                changed[i] = 0.0
            elif failure.kind == "weak":
                changed[i] *= failure.value
            elif failure.kind == "jammed":
                force, length = self._motor.setdefault(k, (tensions[i], lengths[i]))
                changed[i] = max(force + failure.value * (lengths[i] - length), 0.0)
        return changed

    def motor_lengths(self, lengths: FloatArray) -> FloatArray:
        """Return the lengths at the motors for true lengths: jammed motors do not move."""
        if not self._motor:
            return lengths
        changed = lengths.copy()
        for k, (_, length) in self._motor.items():
            changed[self._parts[k]] = length
        return changed

    def change_measurement(self, measured: Measurement, time: float) -> None:
        """Apply the failures until a time to a measurement, in place."""
        for k, failure, i in self._active(time):
            lengths, tensions = measured.lengths, measured.tensions
            if failure.kind in ("length_stuck", "broken"):
                lengths[i] = self._sensor.setdefault(k, lengths[i])
            elif failure.kind in ("length_bias", "off_pulley"):
                lengths[i] += failure.value
            elif failure.kind == "length_drift":
                lengths[i] += failure.value * (time - failure.time)
            elif failure.kind == "length_scale":
                start = self._sensor.setdefault(k, lengths[i])
                lengths[i] = start + failure.value * (lengths[i] - start)
            elif failure.kind == "length_swapped":
                other = self._others[k]
                lengths[i], lengths[other] = lengths[other], lengths[i]
            elif failure.kind == "tension_stuck":
                tensions[i] = self._sensor.setdefault(k, tensions[i])
            elif failure.kind == "tension_dead":
                tensions[i] = 0.0
            elif failure.kind == "encoder_stuck":
                measured.q[i] = self._sensor.setdefault(k, measured.q[i])
                measured.qd[i] = 0.0

    def _active(self, time: float) -> list[tuple[int, FailureSettings, int]]:
        """Return the failures until a time, with their numbers and parts."""
        numbered = zip(range(len(self._parts)), self._settings, self._parts, strict=True)
        return [failure for failure in numbered if failure[1].time <= time]
