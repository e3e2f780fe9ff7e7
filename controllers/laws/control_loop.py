"""Sampled control loop around a control law: integral action, disturbance observer, delay.

Integral action:       correction += T Ki e, stopped while the law is infeasible
Disturbance observer:  w += (1 - exp(-w_o T)) (w_measured - w),
                       w_measured = -L'f - C - G - D qd - M (qd - qd_last)/T - w_e, at the last tick
Delay:                 the law uses the state predicted for the time when its forces take effect

The folder csrc/loop implements the loop. It evaluates the law and the dynamics through callbacks.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray
from controllers.dynamics import Dynamics, actuator_names
from controllers.force_distribution.solution import ForceSolution
from controllers.validation import (
    check_sizes,
    is_finite,
    named_vector,
    require_delay,
    require_positive,
    smallest_forces,
)

from .loop_in_c import Callbacks, LoopInC


class ControlLaw(Protocol):
    """Control law that computes muscle forces from a state and a reference at the same time."""

    @property
    def dynamics(self) -> Dynamics: ...  # noqa: D102

    def error(self, q: FloatArray, reference: FloatArray) -> FloatArray:
        """Return the position of the reference minus the position at q, shape (r,)."""

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
        """Compute the forces; see `JointSpaceController.solve`."""


class ControlLoop:
    """Sampled control loop that evaluates a control law once per period.

    Args:
        names: Names of the r reference coordinates, for messages.
        period: T, in [s].
        ki: Integral gain, a number or shape (r,), in [1/s³].
        observer: Bandwidth w_o of the disturbance observer, in [rad/s]; 0 without an observer.
        delay: Ticks from the measurement of a state until its forces take effect: 0 or 1.
        predict: Whether to compensate the delay by prediction.

    Raises:
        InputError: A setting is invalid.
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
            raise InputError(
                f"observer must be a finite bandwidth in rad/s, at least 0, not {observer!r}"
            )
        require_delay(delay)
        n, m, r = len(law.dynamics.coordinate_names), len(actuator_names(law.dynamics)), len(names)
        self.law = law
        self._n, self._r, self._observer = n, r, observer
        callbacks = Callbacks()
        structure = callbacks.law((n, m, r), self._solve, law.error)
        self._loop = LoopInC(law.dynamics, r, callbacks, structure)
        self._loop.write(ki=named_vector("ki", ki, names), delay=delay, predict=predict)
        self.set_period(period)
        self.reset(smallest_forces(law.dynamics.f_min, law.dynamics.f_max))

    def set_period(self, period: float) -> None:
        """Change the period.

        Args:
            period: T, in [s].

        Raises:
            InputError: The period is not positive and finite.
        """
        require_positive(period=period)
        self._period = period
        self._loop.write(gain=1.0 - math.exp(-self._observer * period))

    @property
    def period(self) -> float:
        """T, in [s]."""
        return self._period

    @property
    def acting(self) -> FloatArray:
        """Muscle forces and motor torques from this tick to the next.

        Shape (a,), in [N] and [N·m]. If other forces are assigned, the observer uses those.
        """
        return self._loop["acting"].copy()

    @acting.setter
    def acting(self, forces: FloatArray) -> None:
        self._loop.write(acting=forces, seen_forces=forces)

    @property
    def disturbance(self) -> FloatArray:
        """Estimated load on the left of the equation of motion, shape (n,), in [N·m] or [N]."""
        return self._loop["disturbance"].copy()

    def reset(self, forces: FloatArray) -> None:
        """Reset the integral action, the observer and the delayed forces.

        Args:
            forces: Forces that act until the first computed forces take effect, shape (a,), in [N]
                and [N·m].
        """
        self._loop.write(remembered=0.0)
        self._loop.write(acting=forces, coming=forces)

    def tick(
        self,
        q: FloatArray,
        qd: FloatArray,
        reference: FloatArray,
        w_e: FloatArray | None = None,
        *,
        applied: FloatArray | None = None,
    ) -> ForceSolution:
        """Execute one tick. Afterwards, `acting` contains the forces to apply.

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
            reference: Position, velocity and acceleration at the time of the tick, shape (3, r).
            w_e: Known generalised external load, shape (n,), in [N·m] or [N], or None.
            applied: Mean muscle forces and motor torques since the last tick, shape (a,), in [N]
                and [N·m] (default: the commanded forces).

        Returns:
            Solution of this tick, which takes effect `delay` ticks later.

        Raises:
            InputError: A vector has another size.
            SimulationError: The state or the reference is not finite.
        """
        check_sizes(self.law.dynamics.coordinate_names, q=q, qd=qd, w_e=w_e)
        if np.shape(reference) != (3, self._r):
            raise InputError(f"the reference has shape {np.shape(reference)}, not (3, {self._r})")
        if applied is not None:
            self._loop.write(seen_forces=applied)
        load = np.zeros(self._n) if w_e is None else w_e
        self._loop.tick(self._period, q, qd, reference, load)
        return self._solution

    def get_state(self) -> FloatArray:
        """Return the state of the loop as a vector, without the state of the law."""
        return self._loop["remembered"].copy()

    def set_state(self, state: FloatArray) -> None:
        """Restore a state from `get_state`.

        Raises:
            InputError: The state has another length, or is not finite.
        """
        self._loop.restore("remembered", state, "control loop")

    def _solve(self, *state: FloatArray, **loads: FloatArray) -> ForceSolution:
        self._solution = self.law.solve(*state, **loads)
        return self._solution
