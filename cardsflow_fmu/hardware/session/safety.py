"""Safety limits between controller and hardware: force limits, ramps, and limits that end a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.cosim.signals.ports import force_unit
from cardsflow_fmu.experiment.settings.hardware import SafetySettings
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.hardware.protocol.signals import actuator_bounds
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.validation import smallest_forces


class TripError(HardwareError):
    """A state or force exceeds a safety limit, and the hardware has been stopped."""


class Guard:
    """Limiter of forces, and monitor of safety limits.

        s = min(1, (t - t_0)/T),   f = f_0 + s (clip(f_d, f_min, f_max) - f_0)

    f_d is the desired force, and f_0 holds the robot at its start pose. In addition the rate of
    f is limited. Arrays contain the muscle forces, followed by the torques of joint motors.

    Args:
        robot: The robot, which specifies force limits and joint limits.
        settings: Ramps, rates and margins.

    Raises:
        InputError: A muscle has no maximum force, or a motor has no maximum torque.

    Attributes:
        f_min, f_max: Force and torque limits, shape (a,), in [N] and [N·m].
        resting_forces: f_min of the muscles and zero torques, shape (a,), in [N] and [N·m].
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
            problem = "missing; hardware requires the maximum force of each muscle"
            raise InputError(problem, key=f"muscles.{name}.f_max")
        bounded = np.isfinite(self.f_min[m:]) & np.isfinite(self.f_max[m:])
        for name in np.array(motors)[~bounded]:
            problem = "missing; hardware requires the maximum torque of each motor"
            raise InputError(problem, key=f"robot.coordinates.{name}.tau_max")
        self.resting_forces = smallest_forces(self.f_min, self.f_max)
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
        self._rest = self.forces = self.resting_forces.copy()

    def start(self, t: float, rest: FloatArray) -> None:
        """Start the ramp. The initial forces are f_min, the initial torques are zero.

        Args:
            t: Time of the run, in [s].
            rest: Forces f_0 that hold the robot, shape (a,), in [N] and [N·m].
        """
        self._start = t
        self._rest = np.clip(rest, self.f_min, self.f_max)
        self.forces = self.resting_forces.copy()

    def require_near(self, q: FloatArray, start: FloatArray) -> None:
        """Check that the robot is close to its start pose.

        Args:
            q: Measured positions, shape (n,), in [rad] or [m].
            start: Start positions, shape (n,), in [rad] or [m].

        Raises:
            HardwareError: The robot is too far away. The message names the joint with the largest
                distance.
        """
        beyond = np.abs(q - start) - self._tolerance
        k = int(np.argmax(beyond))
        if not beyond[k] > 0:
            return
        c = self._coordinates[k]
        raise HardwareError(
            f"joint {c.name!r} is at {q[k]:.4g} {c.unit}, but the start position is {start[k]:.4g} "
            f"{c.unit}; the difference exceeds hardware.start_tolerance, {self._tolerance[k]:.4g} "
            f"{c.unit}: move the robot to its start position, or set hardware.approach"
        )

    def limit(self, t: float, h: float, desired: FloatArray) -> FloatArray:
        """Return the limited forces for the step from t to t + h.

        Args:
            t: Time of the run, in [s].
            h: Time step, in [s].
            desired: Forces and torques of the controller, shape (a,), in [N] and [N·m].

        Raises:
            TripError: A desired force is not finite.
        """
        finite = np.isfinite(desired)
        if not finite.all():
            k = int(np.argmin(finite))
            problem = f"the desired force of {self._actuators[k]} is {desired[k]} {self._units[k]}"
            raise TripError(problem)
        ramp = self._ramp(t)
        bounded = np.clip(desired, self.f_min, self.f_max)
        ramped = bounded if ramp == 1.0 else self._rest + ramp * (bounded - self._rest)
        max_change = self._rates * h
        self.forces = np.clip(ramped, self.forces - max_change, self.forces + max_change)
        return self.forces

    def ramp_down(self, h: float) -> Iterator[FloatArray]:
        """Yield forces that decrease step by step from the last forces to the resting forces.

        Args:
            h: Time step, in [s].
        """
        top = self.forces - self.resting_forces
        steps = int(np.ceil(self._settings.ramp_down / h - 1e-9))
        for remaining in reversed(range(steps)):
            self.forces = self.resting_forces + (remaining / steps) * top
            yield self.forces

    def check(self, q: FloatArray, tensions: FloatArray) -> None:
        """Check joint limits and tension limits.

        Args:
            q: Positions, shape (n,), in [rad] or [m].
            tensions: Tensions, shape (m,), in [N], or shape (0,) if not measured.

        Raises:
            TripError: A limit is exceeded. The message names the joint or muscle, the value and
                the limit.
        """
        if (q < self._lower).any() or (q > self._upper).any():
            self._raise_position_trip(q)
        if tensions.size and (tensions > self._max_tension).any():
            k = int(np.argmax(tensions - self._max_tension))
            problem = f"the tension of muscle {self._muscles[k]!r} is {tensions[k]:.4g} N"
            raise TripError(f"{problem}, above its limit of {self._max_tension[k]:.4g} N")

    def _raise_position_trip(self, q: FloatArray) -> None:
        k = int(np.argmax(np.maximum(self._lower - q, q - self._upper)))
        c = self._coordinates[k]
        side, limit = ("below", c.lower) if q[k] < self._lower[k] else ("above", c.upper)
        margin = abs(limit - (self._lower if side == "below" else self._upper)[k])
        raise TripError(
            f"joint {c.name!r} is at {q[k]:.4g} {c.unit}, {side} its limit of {limit:.4g} {c.unit} "
            f"by more than the margin of {margin:.4g} {c.unit}"
        )

    def _ramp(self, t: float) -> float:
        """Return the ramp factor s at time t."""
        duration = self._settings.ramp_in
        return 1.0 if t - self._start >= duration else (t - self._start) / duration


def _array(values: tuple[float, ...], count: int, default: float) -> FloatArray:
    """Return the values as an array, or the default for each element if there are no values."""
    return np.array(values) if values else np.full(count, default)
