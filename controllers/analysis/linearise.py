"""Linear models of a robot and of its sampled control loop, about a point.

The robot at held forces f, x = (q, qd):           x' = A x + B f
The loop with period T, forces held in between,    x[k+1] = A_T x[k] + B_T f[k - delay]
    A_T, B_T the exact sampling of A, B,           f[k] = K x[k]

The state of a loop with delay also holds the forces on their way. Held forces count: they are in A
as springs, and often as negative ones. Everything is by central differences, at the bounds of
forces as well as between them: there the loop is linear on one side only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import expm

from addin_sdfusion.robot import InputError, SimulationError
from controllers.arrays import FloatArray
from controllers.dynamics import Dynamics, acceleration, actuator_names
from controllers.validation import finite_vector, require_delay, require_period

Controller = Callable[[FloatArray, FloatArray], FloatArray]
"""Forces, shape (m,), of q and qd, at a fixed reference."""
Step = Callable[[FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""q and qd one period on, of q, qd and the forces held."""

DIFFERENCE = 1e-6
"""Default of half the difference of central differences, relative to 1 + |value|."""


@dataclass(frozen=True, eq=False)
class LinearRobot:
    """A robot about a point: x' = A x + B f, x = (q, qd), all as differences from the point.

    Attributes:
        A: Shape (2n, 2n).
        B: Shape (2n, m); its lower half is -M⁻¹ L'.
    """

    A: FloatArray
    B: FloatArray

    @property
    def stiffness(self) -> FloatArray:
        """-d qdd/dq, shape (n, n), in [1/s²]: M⁻¹ times what muscles and gravity hold with.

        A negative eigenvalue -s² is a direction in which the robot falls, as exp(s t).
        """
        n = len(self.A) // 2
        return -self.A[n:, :n]

    def sampled(self, period: float) -> tuple[FloatArray, FloatArray]:
        """A_T, B_T of x[k+1] = A_T x[k] + B_T f[k], forces held for a period.

        Args:
            period: T, in [s].

        Raises:
            InputError: The period is not positive and finite.
        """
        require_period(period)
        size, m = self.B.shape
        block = np.zeros((size + m, size + m))
        block[:size, :size], block[:size, size:] = self.A, self.B
        whole = expm(block * period)
        return whole[:size, :size], whole[:size, size:]


@dataclass(frozen=True, eq=False)
class LinearLoop:
    """A sampled loop about a point: x[k+1] = A x[k].

    Attributes:
        A: Shape (2n, 2n), or (2n + m, 2n + m) with delay: the state then ends with the forces that
            are on their way.
    """

    A: FloatArray

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Eigenvalues of A, the largest first."""
        values = np.linalg.eigvals(self.A).astype(np.complex128)
        return values[np.argsort(-np.abs(values), kind="stable")]

    @property
    def spectral_radius(self) -> float:
        """Largest magnitude of a pole: errors grow or shrink by this factor a tick."""
        return float(np.abs(self.poles[0]))

    @property
    def stable(self) -> bool:
        """Whether small errors die out."""
        return self.spectral_radius < 1.0


def linearise_robot(
    dynamics: Dynamics,
    q: ArrayLike,
    qd: ArrayLike,
    forces: ArrayLike,
    *,
    difference: float = DIFFERENCE,
) -> LinearRobot:
    """Return the robot about a state, at held forces.

    Args:
        dynamics: The robot.
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        forces: f, shape (m,), in [N].
        difference: Of the central differences, relative to 1 + |value|.

    Raises:
        InputError: A size is wrong, or a number not finite.
    """
    x, n = _state(q, qd, len(dynamics.coordinate_names))
    m = len(actuator_names(dynamics))
    f = finite_vector("forces", forces, m)

    def rate(x: FloatArray) -> FloatArray:
        return acceleration(dynamics, x[:n], x[n:], f)

    A = np.zeros((2 * n, 2 * n))
    A[:n, n:] = np.eye(n)
    A[n:] = jacobian(rate, x, difference)
    B = np.zeros((2 * n, m))
    B[n:] = -np.linalg.solve(dynamics.mass_matrix(x[:n]), dynamics.actuator_jacobian(x[:n]).T)
    return LinearRobot(A, B)


def linearise_controller(
    controller: Controller, q: ArrayLike, qd: ArrayLike, *, difference: float = DIFFERENCE
) -> FloatArray:
    """K = df/d(q, qd), shape (m, 2n), in [N/rad] and [N·s/rad], or of [m].

    Args:
        controller: Forces of q and qd, at a fixed reference.
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        difference: Of the central differences, relative to 1 + |value|.

    Raises:
        InputError: A number is not finite, or the sizes differ.
        SimulationError: The forces are not finite.
    """
    x, n = _state(q, qd, np.size(q))
    return jacobian(lambda s: controller(s[:n], s[n:]), x, difference)


def close_loop(
    robot: LinearRobot, controller: FloatArray, period: float, delay: int = 0
) -> LinearLoop:
    """Return the sampled loop of a linear robot and a linear controller.

    Args:
        robot: About the same point.
        controller: K, shape (m, 2n); see `linearise_controller`.
        period: T, in [s].
        delay: Ticks from reading a state until its forces take effect: 0 or 1.

    Raises:
        InputError: The period, the delay or a size is wrong.
    """
    require_delay(delay)
    A, B = robot.sampled(period)
    if controller.shape != B.T.shape:
        raise InputError(f"the controller has shape {controller.shape}, not {B.T.shape}")
    if delay == 0:
        return LinearLoop(A + B @ controller)
    return LinearLoop(np.block([[A, B], [controller, np.zeros((B.shape[1],) * 2)]]))


def linearise_loop(
    step: Step,
    controller: Controller,
    q: ArrayLike,
    qd: ArrayLike,
    *,
    delay: int = 0,
    difference: float = DIFFERENCE,
) -> LinearLoop:
    """Return the sampled loop as it is, numerically: one tick of any plant with any controller.

    Args:
        step: The plant over one period; all that it remembers must be q and qd.
        controller: Forces of q and qd, at a fixed reference; without memory.
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        delay: Ticks from reading a state until its forces take effect: 0 or 1.
        difference: Of the central differences, relative to 1 + |value|.

    Raises:
        InputError: A number is not finite, the sizes differ, or the delay is wrong.
        SimulationError: A state or a force is not finite.
    """
    require_delay(delay)
    x, n = _state(q, qd, np.size(q))
    forces = controller(x[:n], x[n:])

    def tick(state: FloatArray) -> FloatArray:
        q, qd, coming = state[:n], state[n : 2 * n], state[2 * n :]
        new = controller(q, qd)
        after = np.concatenate(step(q, qd, coming if delay else new))
        return np.concatenate([after, new]) if delay else after

    return LinearLoop(jacobian(tick, np.concatenate([x, forces]) if delay else x, difference))


def jacobian(
    function: Callable[[FloatArray], FloatArray], x: FloatArray, difference: float = DIFFERENCE
) -> FloatArray:
    """Return the derivative by central differences, shape (size of the value, size of x).

    Args:
        function: Of a vector, to a vector.
        x: The point.
        difference: Half the difference, relative to 1 + |x|.

    Raises:
        SimulationError: A value is not finite.
    """
    columns = []
    for k, h in enumerate(difference * (1.0 + np.abs(x))):
        ahead, behind = x.copy(), x.copy()
        ahead[k] += h
        behind[k] -= h
        columns.append((function(ahead) - function(behind)) / (ahead[k] - behind[k]))
    J = np.array(columns).T
    if not np.isfinite(J).all():
        raise SimulationError("cannot linearise: a value near the point is not finite")
    return J


def _state(q: ArrayLike, qd: ArrayLike, n: int) -> tuple[FloatArray, int]:
    """(q, qd), checked, and n."""
    return np.concatenate([finite_vector("q", q, n), finite_vector("qd", qd, n)]), n
