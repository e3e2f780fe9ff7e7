"""Sampled control loop around a control law: integral action, disturbance observer, delay.

Integral action:       correction += T Ki e, at rest while the law cannot be met
Disturbance observer:  w += (1 - exp(-w_o T)) (w_measured - w),
                       w_measured = -L'f - C - G - D qd - M (qd - qd_last)/T - w_e, at the last tick
Delay:                 the law is evaluated at the state predicted for when its forces take effect
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray
from controllers.dynamics import (
    Dynamics,
    acceleration,
    actuator_names,
    bias_torque,
    independent_part,
)
from controllers.force_distribution.solution import ForceSolution
from controllers.validation import (
    check_sizes,
    is_finite,
    named_vector,
    require_delay,
    require_period,
    resting,
)


class ControlLaw(Protocol):
    """A law that makes muscle forces of a state and a reference, both of one moment."""

    @property
    def dynamics(self) -> Dynamics: ...  # noqa: D102

    def error(self, q: FloatArray, reference: FloatArray) -> FloatArray:
        """The reference's position less that of q, shape (r,)."""

    def solve(
        self,
        q: FloatArray,
        qd: FloatArray,
        position: FloatArray,
        velocity: FloatArray,
        acceleration: FloatArray,
        *,
        w_e: FloatArray | None = None,
        correction: FloatArray | None = None,
    ) -> ForceSolution:
        """The forces; see `JointSpaceController.solve`."""


class _Tick(NamedTuple):
    """State, forces and load of the last tick, for the observer."""

    q: FloatArray
    qd: FloatArray
    forces: FloatArray
    w_e: FloatArray


class ControlLoop:
    """A control law ticking with a period.

    Args:
        law: The law.
        names: Names of the r rows of its reference, for messages.
        period: T, in [s].
        ki: Integral gain, a number or shape (r,), in [1/s³].
        observer: Bandwidth w_o of the disturbance observer, in [rad/s]; 0 for none.
        delay: Ticks from reading a state until its forces take effect: 0 or 1.
        predict: Whether to make up for the delay.

    Raises:
        InputError: A setting is wrong.

    Attributes:
        law: The law.
        acting: The forces that act from this tick to the next, and behind them the torques of
            motors, shape (a,), in [N] and [N·m].
        disturbance: The observer's generalised load, on the left of the motion equation, shape
            (n,), in [N·m] or [N].
    """

    def __init__(
        self,
        law: ControlLaw,
        names: tuple[str, ...],
        period: float,
        *,
        ki: ArrayLike = 0.0,
        observer: float = 0.0,
        delay: int = 0,
        predict: bool = True,
    ) -> None:
        if not (is_finite(observer) and observer >= 0):
            raise InputError(f"observer must be a bandwidth in rad/s or 0, not {observer!r}")
        require_delay(delay)
        self.law = law
        self._observer, self._delay, self._predict = observer, delay, predict and delay == 1
        self._ki = named_vector("ki", ki, names)
        self.set_period(period)
        n, m = len(law.dynamics.coordinate_names), len(actuator_names(law.dynamics))
        self._n, self._m, self._r = n, m, len(names)
        self.reset(resting(law.dynamics.f_min, law.dynamics.f_max))

    def set_period(self, period: float) -> None:
        """Change the period.

        Args:
            period: T, in [s].

        Raises:
            InputError: It is not positive and finite.
        """
        require_period(period)
        self._period = period
        self._gain = 1.0 - math.exp(-self._observer * period)

    @property
    def period(self) -> float:
        """T, in [s]."""
        return self._period

    def reset(self, forces: FloatArray) -> None:
        """Forget everything.

        Args:
            forces: What acts until the first forces take effect, shape (a,), in [N] and [N·m].
        """
        self.acting = np.array(forces, dtype=np.float64)
        self.disturbance = np.zeros(self._n)
        self._coming = self.acting.copy()
        self._correction = np.zeros(self._r)
        self._last: _Tick | None = None

    def tick(
        self,
        q: FloatArray,
        qd: FloatArray,
        reference: FloatArray,
        w_e: FloatArray | None = None,
        *,
        applied: FloatArray | None = None,
    ) -> ForceSolution:
        """One tick; `acting` is what is to be applied now.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            reference: Position, velocity and acceleration, shape (3, r), at this moment.
            w_e: Known generalised external load, shape (n,), in [N·m] or [N]; none when None.
            applied: Mean tensions of the muscles, and torques of the motors, since the last tick,
                shape (a,), in [N] and [N·m]; what was commanded when None.

        Returns:
            The solution computed at this tick; it takes effect `delay` ticks later.

        Raises:
            InputError: A vector has another size.
            SimulationError: The state or the reference is not finite.
        """
        check_sizes(self.law.dynamics.coordinate_names, q=q, qd=qd, w_e=w_e)
        if np.shape(reference) != (3, self._r):
            raise InputError(f"the reference has shape {np.shape(reference)}, not (3, {self._r})")
        known = np.zeros(self._n) if w_e is None else w_e
        if self._gain:
            self._observe(q, qd, applied)
        load = known + self.disturbance
        acting = self._coming
        y_d, yd_d, ydd_d = reference
        at, at_rate = q, qd
        if self._predict:
            at, at_rate = self._predicted(q, qd, acting, load)
            T = self._period
            y_d = y_d + T * yd_d + 0.5 * T * T * ydd_d
            yd_d = yd_d + T * ydd_d
        solution = self.law.solve(
            at, at_rate, y_d, yd_d, ydd_d, w_e=load, correction=self._correction
        )
        if self._ki.any() and solution.status == "solved":
            e = self.law.error(q, reference[0])
            self._correction = self._correction + self._period * self._ki * e
        self._coming = solution.forces
        self.acting = acting if self._delay else solution.forces
        if self._gain:
            self._last = _Tick(q.copy(), qd.copy(), self.acting, known.copy())
        return solution

    def get_state(self) -> FloatArray:
        """All that the loop remembers, as one row of numbers; the law's own memory is apart."""
        n, m = self._n, self._m
        nothing = _Tick(np.zeros(n), np.zeros(n), np.zeros(m), np.zeros(n))
        return np.concatenate(
            [
                self.acting,
                self._coming,
                self._correction,
                self.disturbance,
                [self._last is not None],
                *(self._last or nothing),
            ]
        )

    def set_state(self, state: FloatArray) -> None:
        """Go back to a state from `get_state`.

        Raises:
            InputError: It has another length, or is not finite.
        """
        n, m = self._n, self._m
        ends = np.cumsum([m, m, self._r, n, 1, n, n, m, n])
        if state.shape != (ends[-1],) or not np.isfinite(state).all():
            raise InputError(f"the control loop's state is {ends[-1]} finite numbers")
        parts = [part.copy() for part in np.split(state, ends[:-1])]
        self.acting, self._coming, self._correction, self.disturbance = parts[:4]
        self._last = _Tick(*parts[5:]) if parts[4][0] else None

    def _observe(self, q: FloatArray, qd: FloatArray, applied: FloatArray | None) -> None:
        """Compare the velocity with what the model made of the last tick's forces."""
        if self._last is None:
            return
        robot, last = self.law.dynamics, self._last
        forces = last.forces if applied is None else applied
        qdd = (qd - last.qd) / self._period
        measured = (
            -robot.actuator_jacobian(last.q).T @ forces
            - bias_torque(robot, last.q, last.qd)
            - robot.mass_matrix(last.q) @ qdd
            - last.w_e
        )
        measured = independent_part(robot, measured)  # the load of the others moves these
        self.disturbance = self.disturbance + self._gain * (measured - self.disturbance)

    def _predicted(
        self, q: FloatArray, qd: FloatArray, forces: FloatArray, load: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """The state one period on, by the midpoint rule."""
        T = self._period
        robot = self.law.dynamics
        half = qd + 0.5 * T * acceleration(robot, q, qd, forces, load)
        qdd = acceleration(robot, q + 0.5 * T * qd, half, forces, load)
        later: FloatArray = q + T * half
        faster: FloatArray = qd + T * qdd
        return later, faster
