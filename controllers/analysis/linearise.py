"""Linear models of a robot and of its sampled control loop at an operating point.

Robot at constant forces f, with x = (q, qd):      x' = A x + B f
Loop with period T and zero-order hold:            x[k+1] = A_T x[k] + B_T f[k - delay]
    A_T, B_T are A, B, sampled exactly,            f[k] = K x[k]

With delay, the state of the loop also contains the forces that have not taken effect yet. The
constant forces contribute a stiffness to A, which is often negative. All derivatives are central
differences. At a force limit the loop is only linear on one side, so that the result is an average
of both sides.
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
from controllers.validation import finite_vector, require_delay, require_positive

Controller = Callable[[FloatArray, FloatArray], FloatArray]
"""Function of q and qd that returns the forces, shape (m,), at a constant reference."""
Step = Callable[[FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""Function of q, qd and constant forces that returns q and qd one period later."""

DIFFERENCE = 1e-6
"""Default step of the central differences, relative to 1 + |value|."""


@dataclass(frozen=True, eq=False)
class LinearRobot:
    """Linear robot model x' = A x + B f, x = (q, qd); x and f are deviations from the point.

    Attributes:
        A: Shape (2n, 2n).
        B: Shape (2n, m); its lower half is -M⁻¹ L'.
    """

    A: FloatArray
    B: FloatArray

    @property
    def stiffness(self) -> FloatArray:
        """-d qdd/dq, shape (n, n), in [1/s²]: M⁻¹ times the stiffness by muscles and gravity.

        A negative eigenvalue -s² is an unstable direction, along which deviations grow as exp(s t).
        """
        n = len(self.A) // 2
        return -self.A[n:, :n]

    def sampled(self, period: float) -> tuple[FloatArray, FloatArray]:
        """Return A_T, B_T of x[k+1] = A_T x[k] + B_T f[k], with forces constant over a period.

        Args:
            period: T, in [s].

        Raises:
            InputError: The period is not positive and finite.
        """
        require_positive(period=period)
        size, m = self.B.shape
        block = np.zeros((size + m, size + m))
        block[:size, :size], block[:size, size:] = self.A, self.B
        exponential = expm(block * period)
        return exponential[:size, :size], exponential[:size, size:]


@dataclass(frozen=True, eq=False)
class LinearLoop:
    """Sampled loop at an operating point: x[k+1] = A x[k].

    Attributes:
        A: Shape (2n, 2n), or (2n + m, 2n + m) with delay. The state then ends with the forces that
            have not taken effect yet.
    """

    A: FloatArray

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Eigenvalues of A, the largest first."""
        values = np.linalg.eigvals(self.A).astype(np.complex128)
        return values[np.argsort(-np.abs(values), kind="stable")]

    @property
    def spectral_radius(self) -> float:
        """Largest magnitude of a pole: the growth factor of errors per tick, stable below 1."""
        return float(np.abs(self.poles[0]))


def linearise_robot(
    dynamics: Dynamics,
    q: ArrayLike,
    qd: ArrayLike,
    forces: ArrayLike,
    *,
    difference: float = DIFFERENCE,
) -> LinearRobot:
    """Linearise a robot at a state and constant forces.

    Args:
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        forces: f, shape (m,), in [N].
        difference: Step of the central differences, relative to 1 + |value|.

    Raises:
        InputError: A size is wrong, or a number is not finite.
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
    """Compute K = df/d(q, qd), shape (m, 2n), in [N/rad] and [N·s/rad], or [N/m] and [N·s/m].

    Args:
        controller: Function of q and qd that returns forces, at a constant reference.
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        difference: Step of the central differences, relative to 1 + |value|.

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
        robot: The robot, linearised at the same point.
        controller: K, shape (m, 2n); see `linearise_controller`.
        period: T, in [s].
        delay: Ticks from the measurement of a state until its forces take effect: 0 or 1.

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
    """Linearise one tick of a plant and a controller numerically.

    Args:
        step: The plant over one period. Its state must consist of q and qd.
        controller: Function of q and qd that returns forces, at a constant reference, without an
            internal state.
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        delay: Ticks from the measurement of a state until its forces take effect: 0 or 1.
        difference: Step of the central differences, relative to 1 + |value|.

    Raises:
        InputError: A number is not finite, the sizes differ, or the delay is wrong.
        SimulationError: A state or a force is not finite.
    """
    require_delay(delay)
    x, n = _state(q, qd, np.size(q))
    forces = controller(x[:n], x[n:])

    def tick(state: FloatArray) -> FloatArray:
        q, qd, pending = state[:n], state[n : 2 * n], state[2 * n :]
        new = controller(q, qd)
        after = np.concatenate(step(q, qd, pending if delay else new))
        return np.concatenate([after, new]) if delay else after

    return LinearLoop(jacobian(tick, np.concatenate([x, forces]) if delay else x, difference))


def jacobian(
    function: Callable[[FloatArray], FloatArray], x: FloatArray, difference: float = DIFFERENCE
) -> FloatArray:
    """Compute a Jacobian by central differences, shape (size of the value, size of x).

    Args:
        function: Function from a vector to a vector.
        difference: Step to each side, relative to 1 + |x|.

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
        raise SimulationError("cannot linearise: a value near the operating point is not finite")
    return J


def _state(q: ArrayLike, qd: ArrayLike, n: int) -> tuple[FloatArray, int]:
    """Check sizes and values, and return the vector (q, qd) and n."""
    return np.concatenate([finite_vector("q", q, n), finite_vector("qd", qd, n)]), n
