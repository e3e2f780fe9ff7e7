"""Stiffness of a joint configuration that muscles hold with given forces.

With muscle torques tau = -L(q)'f and loads G(q), a small displacement dq from equilibrium causes
the restoring torque -K dq with

    K = K_g + K_c + K_l,   K_g = d(L'f)/dq at held f = sum_i f_i d²l_i/dq²,
                           K_c = L' diag(k) L,   K_l = dG/dq.

The geometric stiffness K_g from pretension can be negative. Pretension then destabilises the robot,
and the stiffness of the muscles or a controller must compensate it. Behzadipour, Khajepour,
"Stiffness of cable-based parallel manipulators with application to stability analysis", J.
Mechanical Design 128 (2006).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, SimulationError
from controllers.arrays import FloatArray
from controllers.dynamics import Dynamics, TaskDynamics
from controllers.validation import finite_vector, is_finite, named_vector

STEP = 1e-3
"""Step h of the finite differences, in [rad] or [m].

The differences are central and of fourth order. Their truncation error is about h⁴/30 times the
fifth derivative, and their rounding error is about eps/h. For muscle paths of 0.1 to 1 m both are
equal near h = eps^(1/5) = 7e-4. At 1e-3 both are about 1e-13 relative to L.
"""

_ZERO = 1e-9  # an eigenvalue is zero below this value, relative to the largest eigenvalue


@dataclass(frozen=True, eq=False)
class Stiffness:
    """Symmetric stiffness matrices in joint coordinates, shape (n, n), in [N·m/rad] or [N/m].

    Attributes:
        geometric: K_g, from the constant muscle forces.
        cable: K_c, from the stiffness of the muscles; zero for constant muscle forces.
        load: K_l, from gravity.
        asymmetry: Largest difference between K_g and its transpose before symmetrisation. The exact
            K_g is symmetric, so this is the error of the finite differences.
        coordinate_names: n names.
    """

    geometric: FloatArray
    cable: FloatArray
    load: FloatArray
    asymmetry: float
    coordinate_names: tuple[str, ...]

    @property
    def total(self) -> FloatArray:
        """K = K_g + K_c + K_l."""
        return self.geometric + self.cable + self.load

    @property
    def is_stable(self) -> bool:
        """Whether K is positive definite, so that every displacement is opposed."""
        values = np.linalg.eigvalsh(self.total)
        return bool(values[0] > _ZERO * np.abs(values).max())

    def warnings(self) -> list[str]:
        """Return warnings about negative stiffness."""
        messages = []
        values, directions = np.linalg.eigh(self.geometric)
        if values[0] < -_ZERO * np.abs(values).max():
            messages.append(
                f"the muscle forces destabilise the robot: geometric stiffness {values[0]:.4g} "
                f"along {self._format_direction(directions[:, 0])}; reduce the pretension"
            )
        if not self.is_stable:
            values, directions = np.linalg.eigh(self.total)
            messages.append(
                f"the configuration is unstable without control: stiffness {values[0]:.4g} along "
                f"{self._format_direction(directions[:, 0])}"
            )
        return messages

    def rates(self, M: ArrayLike) -> FloatArray:
        """Return the eigenvalues of -M⁻¹K in ascending order, shape (n,), in [1/s²].

        A positive eigenvalue is an unstable mode at constant forces: a displacement grows as
        exp(sqrt(eigenvalue) t). The position gain Kp must exceed it.

        Args:
            M: Mass matrix, shape (n, n).
        """
        C = np.linalg.cholesky(np.asarray(M, dtype=np.float64))
        half = np.linalg.solve(C, self.total)
        rates: FloatArray = np.linalg.eigvalsh(-np.linalg.solve(C, half.T))
        return rates

    def compliance(self, J: ArrayLike) -> FloatArray:
        """Return the compliance of task coordinates, J K⁻¹ J', shape (k, k), in [m/N] or [rad/N].

        Args:
            J: Task Jacobian, shape (k, n).

        Raises:
            InputError: J has another shape.
            SimulationError: The configuration is not a stable equilibrium.
        """
        J_ = np.asarray(J, dtype=np.float64)
        n = len(self.coordinate_names)
        if J_.ndim != 2 or J_.shape[1] != n:
            raise InputError(f"J must have shape (k, {n}), not {J_.shape}")
        if not self.is_stable:
            raise SimulationError(f"the compliance does not exist: {self.warnings()[-1]}")
        compliance: FloatArray = J_ @ np.linalg.solve(self.total, J_.T)
        return 0.5 * (compliance + compliance.T)

    def task_stiffness(self, J: ArrayLike) -> FloatArray:
        """Return the inverse of the compliance, shape (k, k), in [N/m] or [N·m/rad].

        Directions outside the task move freely.

        Args:
            J: Task Jacobian, shape (k, n).

        Raises:
            InputError: J has another shape, or its rows are linearly dependent.
            SimulationError: The configuration is not stable.
        """
        compliance = self.compliance(J)
        values = np.linalg.eigvalsh(compliance)
        if values[0] <= _ZERO * values[-1]:
            raise InputError(
                "the task coordinates are linearly dependent; their stiffness does not exist"
            )
        return np.asarray(np.linalg.inv(compliance), dtype=np.float64)

    def _format_direction(self, direction: FloatArray) -> str:
        names = zip(self.coordinate_names, direction, strict=True)
        return ", ".join(f"{value:+.2f} {name}" for name, value in names if abs(value) > 0.01)


def stiffness(
    dynamics: Dynamics,
    q: ArrayLike,
    forces: ArrayLike,
    *,
    muscle_stiffness: ArrayLike = 0.0,
    step: float = STEP,
) -> Stiffness:
    """Compute the stiffness at a configuration, from L and finite differences.

    Args:
        q: Joint positions, shape (n,), in [rad] or [m].
        forces: f, shape (m,), in [N].
        muscle_stiffness: k, a number or shape (m,), in [N/m]; 0 for constant muscle forces.
        step: Step of the finite differences, in [rad] or [m].

    Raises:
        InputError: A size is wrong, or a number is out of range.
    """
    q_ = finite_vector("q", q, len(dynamics.coordinate_names))
    f = finite_vector("forces", forces, len(dynamics.muscle_names))
    k = named_vector("muscle_stiffness", muscle_stiffness, dynamics.muscle_names)
    if not (is_finite(step) and step > 0):
        raise InputError(f"step must be finite and positive: {step}")
    K_g = _jacobian(lambda x: dynamics.muscle_jacobian(x).T @ f, q_, step)
    K_l = _jacobian(dynamics.gravity, q_, step)
    half = np.sqrt(k)[:, None] * dynamics.muscle_jacobian(q_)
    return Stiffness(
        0.5 * (K_g + K_g.T),
        half.T @ half,
        0.5 * (K_l + K_l.T),
        float(np.abs(K_g - K_g.T).max(initial=0.0)),
        dynamics.coordinate_names,
    )


def task_stiffness(
    dynamics: TaskDynamics, q: ArrayLike, forces: ArrayLike, muscle_stiffness: ArrayLike
) -> FloatArray:
    """Compute the stiffness of the task coordinates, shape (k, k).

    Args:
        q: Joint positions, shape (n,), in [rad] or [m].
        forces: f, shape (m,), in [N].
        muscle_stiffness: k, a number or shape (m,), in [N/m].

    Raises:
        InputError: A size is wrong, a number is out of range, or the task coordinates are linearly
            dependent.
        SimulationError: The configuration is not stable.
    """
    joint = stiffness(dynamics, q, forces, muscle_stiffness=muscle_stiffness)
    return joint.task_stiffness(dynamics.task_jacobian(np.asarray(q, dtype=np.float64)))


def _jacobian(function: Callable[[FloatArray], FloatArray], q: FloatArray, h: float) -> FloatArray:
    """Compute a Jacobian by central differences of fourth order, shape (n, n)."""
    columns = []
    for j in range(len(q)):
        e = np.zeros(len(q))
        e[j] = h
        near = function(q + e) - function(q - e)
        far = function(q + 2.0 * e) - function(q - 2.0 * e)
        columns.append((8.0 * near - far) / (12.0 * h))
    return np.array(columns).T
