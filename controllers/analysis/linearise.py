"""Linear model of a robot at an operating point.

Robot at constant forces f, with x = (q, qd):      x' = A x + B f
Sampled with period T and zero-order hold:         x[k+1] = A_T x[k] + B_T f[k]

A sampled loop with a controller f[k] = K x[k] has the matrix A_T + B_T K; `jacobian` computes K.
The constant forces contribute a stiffness to A, which is often negative. All derivatives are
central differences. At a force limit a controller is only linear on one side, so that K is an
average of both sides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import expm

from addin_sdfusion.robot import SimulationError
from controllers.arrays import FloatArray
from controllers.dynamics import Dynamics, acceleration, actuator_names
from controllers.validation import finite_vector, require_period

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
        require_period(period)
        size, m = self.B.shape
        block = np.zeros((size + m, size + m))
        block[:size, :size], block[:size, size:] = self.A, self.B
        exponential = expm(block * period)
        return exponential[:size, :size], exponential[:size, size:]


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
        dynamics: The robot.
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


def jacobian(
    function: Callable[[FloatArray], FloatArray], x: FloatArray, difference: float = DIFFERENCE
) -> FloatArray:
    """Compute a Jacobian by central differences, shape (size of the value, size of x).

    Args:
        function: Function from a vector to a vector.
        x: The point.
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
