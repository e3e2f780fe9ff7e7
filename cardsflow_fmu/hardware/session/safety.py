"""Safety between controller and hardware: bounds, ramps, and limits that end a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.settings.hardware import SafetySettings
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.utils.arrays import FloatArray


class TripError(HardwareError):
    """A safety limit was exceeded: the hardware has been stopped."""


class Guard:
    """The limits of forces and states.

        s = min(1, (t - t_0)/T),   f = f_0 + s (clip(f_d, f_min, f_max) - f_0)

    with the desired force f_d, and f_0 that holds the robot at its start; then limited in rate.

    Args:
        robot: The robot, with the bounds of its forces and the limits of its joints.
        settings: Ramps, rates and margins.

    Raises:
        InputError: A muscle has no largest force.

    Attributes:
        f_min, f_max: Bounds, shape (m,), in [N].
        forces: Forces of the last step, shape (m,), in [N].
    """

    def __init__(self, robot: Robot, settings: SafetySettings) -> None:
        self._settings = settings
        self._muscles = [muscle.name for muscle in robot.muscles]
        self._coordinates = robot.coordinates
        self.f_min = np.array([muscle.f_min for muscle in robot.muscles])
        self.f_max = np.array([muscle.f_max for muscle in robot.muscles])
        for name in np.array(self._muscles)[~np.isfinite(self.f_max)]:
            what = "hardware needs the largest force that a muscle may be given"
            raise InputError(what, key=f"muscles.{name}.f_max")
        n, m = len(robot.coordinates), len(robot.muscles)
        self._rates = _array(settings.force_rate, m, np.inf)
        self._tension_max = _array(settings.tension_max, m, np.inf)
        self._tolerance = _array(settings.start_tolerance, n, np.inf)
        margin = _array(settings.position_margin, n, 0.0)
        self._lower = np.array([c.lower for c in robot.coordinates]) - margin
        self._upper = np.array([c.upper for c in robot.coordinates]) + margin
        self._start = 0.0
        self._rest = self.forces = self.f_min.copy()

    def start(self, t: float, rest: FloatArray) -> None:
        """Begin the ramp, with every muscle at its f_min.

        Args:
            t: In [s].
            rest: f_0, shape (m,), in [N].
        """
        self._start = t
        self._rest = np.clip(rest, self.f_min, self.f_max)
        self.forces = self.f_min.copy()

    def require_near(self, q: FloatArray, start: FloatArray) -> None:
        """Refuse a robot that is far from its start.

        Args:
            q: Measured positions, shape (n,), in [rad] or [m].
            start: Positions at the start, shape (n,).

        Raises:
            HardwareError: It is too far; the message names the joint that is farthest.
        """
        beyond = np.abs(q - start) - self._tolerance
        k = int(np.argmax(beyond))
        if not beyond[k] > 0:
            return
        c = self._coordinates[k]
        raise HardwareError(
            f"joint {c.name!r} is at {q[k]:.4g} {c.unit}, and is to start at {start[k]:.4g} "
            f"{c.unit}: farther than hardware.start_tolerance, {self._tolerance[k]:.4g} {c.unit}; "
            "move the robot there, or set hardware.approach"
        )

    def limit(self, t: float, h: float, desired: FloatArray) -> FloatArray:
        """The forces over the step from t to t + h.

        Args:
            t: In [s].
            h: In [s].
            desired: Forces of the controller, shape (m,), in [N].

        Raises:
            TripError: A force is not finite.
        """
        finite = np.isfinite(desired)
        if not finite.all():
            k = int(np.argmin(finite))
            raise TripError(f"the desired force of muscle {self._muscles[k]!r} is {desired[k]} N")
        ramp = self._ramp(t)
        bounded = np.clip(desired, self.f_min, self.f_max)
        ramped = bounded if ramp == 1.0 else self._rest + ramp * (bounded - self._rest)
        most = self._rates * h
        self.forces = np.clip(ramped, self.forces - most, self.forces + most)
        return self.forces

    def ramp_down(self, h: float) -> Iterator[FloatArray]:
        """Forces, step by step, from the last ones to f_min.

        Args:
            h: Length of a step, in [s].
        """
        top = self.forces - self.f_min
        steps = int(np.ceil(self._settings.ramp_down / h - 1e-9))
        for left in reversed(range(steps)):
            self.forces = self.f_min + (left / steps) * top
            yield self.forces

    def check(self, q: FloatArray, tensions: FloatArray) -> None:
        """End a run at a joint's or a tension's limit.

        Args:
            q: Positions, shape (n,), in [rad] or [m].
            tensions: Shape (m,), in [N], or (0,) where none are measured.

        Raises:
            TripError: The message names joint or muscle, the value and the limit.
        """
        if (q < self._lower).any() or (q > self._upper).any():
            self._trip_by_position(q)
        if tensions.size and (tensions > self._tension_max).any():
            k = int(np.argmax(tensions - self._tension_max))
            raise TripError(
                f"muscle {self._muscles[k]!r} pulls with {tensions[k]:.4g} N, above its limit of "
                f"{self._tension_max[k]:.4g} N"
            )

    def _trip_by_position(self, q: FloatArray) -> None:
        k = int(np.argmax(np.maximum(self._lower - q, q - self._upper)))
        c = self._coordinates[k]
        side, limit = ("below", c.lower) if q[k] < self._lower[k] else ("above", c.upper)
        margin = abs(limit - (self._lower if side == "below" else self._upper)[k])
        raise TripError(
            f"joint {c.name!r} is at {q[k]:.4g} {c.unit}, {side} its limit of {limit:.4g} {c.unit} "
            f"by more than the margin of {margin:.4g} {c.unit}"
        )

    def _ramp(self, t: float) -> float:
        """The factor s at time t."""
        duration = self._settings.ramp_in
        return 1.0 if t - self._start >= duration else (t - self._start) / duration


def _array(values: tuple[float, ...], count: int, default: float) -> FloatArray:
    """The values; the default everywhere where there are none."""
    return np.array(values) if values else np.full(count, default)
