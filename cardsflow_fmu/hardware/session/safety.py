"""Safety between controller and hardware: bounds, ramps, and limits that end a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.cosim.signals.ports import force_unit
from cardsflow_fmu.experiment.settings.hardware import SafetySettings
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.validation import smallest_forces


class TripError(HardwareError):
    """A safety limit was exceeded: the hardware has been stopped."""


class Guard:
    """The limits of forces and states.

        s = min(1, (t - t_0)/T),   f = f_0 + s (clip(f_d, f_min, f_max) - f_0)

    with the desired force f_d, and f_0 that holds the robot at its start; then limited in rate.
    Torques of motors at joints stand behind the muscles' forces; their least is no torque.

    Args:
        robot: The robot, with the bounds of its forces and the limits of its joints.
        settings: Ramps, rates and margins.

    Raises:
        InputError: A muscle has no largest force, or a motor no largest torque.

    Attributes:
        f_min, f_max: Bounds, shape (a,), in [N] and [N·m].
        least: The smallest forces within them, shape (a,).
        forces: Forces of the last step, shape (a,), in [N] and [N·m].
    """

    def __init__(self, robot: Robot, settings: SafetySettings) -> None:
        self._settings = settings
        self._muscles = [muscle.name for muscle in robot.muscles]
        self._units = [*("N" for _ in robot.muscles), *map(force_unit, robot.motors)]
        motors = [motor.name for motor in robot.motors]
        self._actuators = [f"muscle {name!r}" for name in self._muscles]
        self._actuators += [f"motor {name!r}" for name in motors]
        self._coordinates = robot.coordinates
        self.f_min, self.f_max = actuator_bounds(robot)
        m = len(robot.muscles)
        for name in np.array(self._muscles)[~np.isfinite(self.f_max[:m])]:
            what = "hardware needs the largest force that a muscle may be given"
            raise InputError(what, key=f"muscles.{name}.f_max")
        bounded = np.isfinite(self.f_min[m:]) & np.isfinite(self.f_max[m:])
        for name in np.array(motors)[~bounded]:
            what = "hardware needs the largest torque that a motor may be given either way"
            raise InputError(what, key=f"robot.coordinates.{name}.tau_max")
        self.least = smallest_forces(self.f_min, self.f_max)
        n = len(robot.coordinates)
        rates = [_array(settings.force_rate, m, np.inf)]
        rates.append(_array(settings.torque_rate, len(motors), np.inf))
        self._rates = np.concatenate(rates)
        self._max_tension = _array(settings.max_tension, m, np.inf)
        self._tolerance = _array(settings.start_tolerance, n, np.inf)
        margin = _array(settings.position_margin, n, 0.0)
        self._lower = np.array([c.lower for c in robot.coordinates]) - margin
        self._upper = np.array([c.upper for c in robot.coordinates]) + margin
        self._start = 0.0
        self._rest = self.forces = self.least.copy()

    def start(self, t: float, rest: FloatArray) -> None:
        """Begin the ramp, with every muscle at its f_min and no torque.

        Args:
            t: In [s].
            rest: f_0, shape (a,), in [N] and [N·m].
        """
        self._start = t
        self._rest = np.clip(rest, self.f_min, self.f_max)
        self.forces = self.least.copy()

    def require_near(self, q: FloatArray, start: FloatArray) -> None:
        """Reject a robot that is far from its start.

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
        """Return the forces over the step from t to t + h.

        Args:
            t: In [s].
            h: In [s].
            desired: Forces and torques of the controller, shape (a,), in [N] and [N·m].

        Raises:
            TripError: A force is not finite.
        """
        finite = np.isfinite(desired)
        if not finite.all():
            k = int(np.argmin(finite))
            what = f"the desired force of {self._actuators[k]} is {desired[k]} {self._units[k]}"
            raise TripError(what)
        ramp = self._ramp(t)
        bounded = np.clip(desired, self.f_min, self.f_max)
        ramped = bounded if ramp == 1.0 else self._rest + ramp * (bounded - self._rest)
        most = self._rates * h
        self.forces = np.clip(ramped, self.forces - most, self.forces + most)
        return self.forces

    def ramp_down(self, h: float) -> Iterator[FloatArray]:
        """Forces, step by step, from the last ones to the least.

        Args:
            h: Length of a step, in [s].
        """
        top = self.forces - self.least
        steps = int(np.ceil(self._settings.ramp_down / h - 1e-9))
        for left in reversed(range(steps)):
            self.forces = self.least + (left / steps) * top
            yield self.forces

    def check(self, q: FloatArray, tensions: FloatArray) -> None:
        """End a run at a joint's or a tension's limit.

        Args:
            q: Positions, shape (n,), in [rad] or [m].
            tensions: Shape (m,), in [N], or (0,) if none are measured.

        Raises:
            TripError: The message names joint or muscle, the value and the limit.
        """
        if (q < self._lower).any() or (q > self._upper).any():
            self._trip_by_position(q)
        if tensions.size and (tensions > self._max_tension).any():
            k = int(np.argmax(tensions - self._max_tension))
            raise TripError(
                f"muscle {self._muscles[k]!r} pulls with {tensions[k]:.4g} N, above its limit of "
                f"{self._max_tension[k]:.4g} N"
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
        """Return the factor s at time t."""
        duration = self._settings.ramp_in
        return 1.0 if t - self._start >= duration else (t - self._start) / duration


def actuator_bounds(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Bounds of the muscles' forces and, behind them, of the motors' torques, shape (a,) each."""
    low = [*(m.f_min for m in robot.muscles), *(c.tau_min for c in robot.motors)]
    high = [*(m.f_max for m in robot.muscles), *(c.tau_max for c in robot.motors)]
    return np.array(low), np.array(high)


def _array(values: tuple[float, ...], count: int, default: float) -> FloatArray:
    """Return the values; the default everywhere if there are none."""
    return np.array(values) if values else np.full(count, default)
